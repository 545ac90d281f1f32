#include "mlic_core/imu/accelerometer_lag.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/imu/cubic_signal.h"
#include "mlic_core/imu/imu_samples.h"

namespace mlic {
namespace {

constexpr double kStep = 0.025;  // s; from: guard, a parabola refines it
constexpr int kSteps = 6;        // to either side; from: guard, the lag of kitti_0005 is 0.05 s

// The samples with the specific force that was read `lag` later.
std::vector<ImuSample> Shifted(const std::vector<ImuSample>& imu, double lag) {
  std::vector<double> times;
  std::vector<Eigen::Vector3d> forces;
  for (const ImuSample& sample : imu) {
    times.push_back(sample.time);
    forces.push_back(sample.specific_force);
  }
  const CubicSignal signal(times, forces, LongestBridgedPeriod(MedianPeriod(imu)));
  std::vector<ImuSample> shifted;
  for (ImuSample sample : imu) {
    const double time = sample.time + lag;
    const auto next = std::upper_bound(times.begin(), times.end(), time);
    if (next == times.begin() || next == times.end()) continue;
    const std::size_t interval = static_cast<std::size_t>(next - times.begin()) - 1;
    sample.specific_force = signal.Value(interval, time - times[interval]);
    shifted.push_back(sample);
  }
  return shifted;
}

}  // namespace

AccelerometerLag MeasureAccelerometerLag(const std::vector<ImuSample>& imu,
                                         const std::vector<TimedPose>& poses,
                                         const AngularRateAlignment& alignment,
                                         const std::optional<LeverArmGuess>& guess) {
  const std::vector<ImuSample> ordered = OrderedFiniteSamples(imu);
  // Minus the logarithm of the likelihood, the residuals' size left free. Neighbouring poses share errors:
  // three of them count as one.
  const double independent = static_cast<double>(poses.size()) / 3.0;
  const auto cost = [&](double lag) {
    const GravityLeverArm arm =
        SolveGravityLeverArm(Shifted(ordered, lag), poses, alignment.R_imu_lidar, alignment.time_offset,
                             alignment.gyroscope_bias, guess, alignment.rotation_covariance);
    return arm.valid ? 3.0 * independent * std::log(std::max(arm.residual_rms, 1e-9))
                     : std::numeric_limits<double>::infinity();
  };
  std::vector<double> costs(2 * kSteps + 1);
  ParallelFor(costs.size(), [&](std::size_t i) { costs[i] = cost((static_cast<int>(i) - kSteps) * kStep); });
  const auto least = std::min_element(costs.begin(), costs.end());
  AccelerometerLag result;
  if (least == costs.begin() || least + 1 == costs.end() || !std::isfinite(*least)) return result;
  const double middle = (static_cast<double>(least - costs.begin()) - kSteps) * kStep;
  // A parabola through the least and its neighbours; real data are rough within a step.
  const double before = *(least - 1), after = *(least + 1);
  const double curvature = (before - 2.0 * *least + after) / (kStep * kStep);
  if (!std::isfinite(curvature) || curvature <= 0.0) return result;
  result.lag = middle - (after - before) / (2.0 * kStep * curvature);
  result.sigma = 1.0 / std::sqrt(curvature);
  result.valid = true;
  return result;
}

}  // namespace mlic
