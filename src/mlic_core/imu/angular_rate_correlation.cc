#include "mlic_core/imu/angular_rate_correlation.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/wahba.h"
#include "mlic_core/imu/robust.h"
#include "mlic_core/imu/rotation_fit.h"

namespace mlic {
namespace {

// from: guard, a peak is refined afterwards.
constexpr double kGridStep = 0.01;  // s, well below the width of a peak
// from: measured, together with kSegmentLength (pose_segments.h).
constexpr double kIntervalLength = 0.2;       // s: longer ones are less noisy, shorter ones sharper
constexpr std::size_t kFewestIntervals = 20;  // from: guard

struct RateInterval {
  double start = 0.0;  // LiDAR clock
  double end = 0.0;
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  // LiDAR frame, rad/s
  double weight = 1.0;
};

std::vector<RateInterval> LidarRates(const std::vector<TimedPose>& poses) {
  std::vector<double> periods;
  for (std::size_t i = 1; i < poses.size(); ++i) periods.push_back(poses[i].time - poses[i - 1].time);
  const double period = std::max(Median(periods), 1e-6);
  const std::size_t stride =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kIntervalLength / period)));
  std::vector<RateInterval> intervals;
  for (std::size_t i = stride; i < poses.size(); ++i) {
    const TimedPose& from = poses[i - stride];
    const TimedPose& to = poses[i];
    const double duration = to.time - from.time;
    if (duration > 1.6 * static_cast<double>(stride) * period) continue;
    const Eigen::Quaterniond turn = from.pose.rotation.conjugate() * to.pose.rotation;
    intervals.push_back({from.time, to.time, Log(turn) / duration, 1.0});
  }
  return intervals;
}

// Moments of the pairs (a, b) of one offset.
struct Pairing {
  std::size_t count = 0;
  Eigen::Vector3d mean_imu = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_lidar = Eigen::Vector3d::Zero();
  double correlation = 0.0;
  Eigen::Quaterniond R_imu_lidar = Eigen::Quaterniond::Identity();
};

Eigen::Vector3d ImuRate(const GyroIntegration& gyro, const RateInterval& interval, double offset) {
  return Log(gyro.RotationBetween(interval.start + offset, interval.end + offset)) /
         (interval.end - interval.start);
}

Pairing Pair(const GyroIntegration& gyro, const std::vector<RateInterval>& intervals,
             const std::optional<Eigen::Quaterniond>& R_guess, double offset) {
  Pairing pairing;
  double weights = 0.0, square_imu = 0.0, square_lidar = 0.0;
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (const RateInterval& interval : intervals) {
    if (interval.weight <= 0.0 || !gyro.Covers(interval.start + offset, interval.end + offset)) continue;
    const Eigen::Vector3d a = ImuRate(gyro, interval, offset);
    const Eigen::Vector3d& b = interval.rate;
    weights += interval.weight;
    pairing.mean_imu += interval.weight * a;
    pairing.mean_lidar += interval.weight * b;
    cross += interval.weight * a * b.transpose();
    square_imu += interval.weight * a.squaredNorm();
    square_lidar += interval.weight * b.squaredNorm();
    ++pairing.count;
  }
  if (pairing.count < kFewestIntervals) return pairing;
  pairing.mean_imu /= weights;
  pairing.mean_lidar /= weights;
  cross -= weights * pairing.mean_imu * pairing.mean_lidar.transpose();
  square_imu -= weights * pairing.mean_imu.squaredNorm();
  square_lidar -= weights * pairing.mean_lidar.squaredNorm();
  double fit = 0.0;
  pairing.R_imu_lidar = Eigen::Quaterniond(WahbaRotation(cross, &fit));
  if (R_guess) {
    fit = (R_guess->toRotationMatrix().transpose() * cross).trace();
    pairing.R_imu_lidar = *R_guess;
  }
  const double norm = std::sqrt(std::max(square_imu, 0.0) * std::max(square_lidar, 0.0));
  pairing.correlation = norm > 1e-20 ? fit / norm : 0.0;
  return pairing;
}

// Weights by the residuals of the intervals at one offset, its rotation and its means.
void Reweight(const GyroIntegration& gyro, double offset, const Pairing& pairing,
              std::vector<RateInterval>* intervals) {
  std::vector<double> norms;
  std::vector<double> covered_norms;
  for (const RateInterval& interval : *intervals) {
    const bool covered = gyro.Covers(interval.start + offset, interval.end + offset);
    const Eigen::Vector3d residual = ImuRate(gyro, interval, offset) - pairing.mean_imu -
                                     pairing.R_imu_lidar * (interval.rate - pairing.mean_lidar);
    norms.push_back(covered ? residual.norm() : 0.0);
    if (covered) covered_norms.push_back(norms.back());
  }
  const double sigma = std::max(1e-4, SigmaFromNorms(covered_norms));
  for (std::size_t i = 0; i < norms.size(); ++i) (*intervals)[i].weight = TukeyWeight(norms[i], sigma);
}

std::vector<Pairing> Scan(const GyroIntegration& gyro, const std::vector<RateInterval>& intervals,
                          const std::optional<Eigen::Quaterniond>& R_guess,
                          const std::vector<double>& offsets) {
  std::vector<Pairing> pairings(offsets.size());
  ParallelFor(offsets.size(),
              [&](std::size_t i) { pairings[i] = Pair(gyro, intervals, R_guess, offsets[i]); });
  std::size_t most = 0;
  for (const Pairing& pairing : pairings) most = std::max(most, pairing.count);
  // A short overlap correlates by chance.
  for (Pairing& pairing : pairings) {
    if (2 * pairing.count < most) pairing.correlation = 0.0;
  }
  return pairings;
}

std::size_t Highest(const std::vector<Pairing>& pairings) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < pairings.size(); ++i) {
    if (pairings[i].correlation > pairings[best].correlation) best = i;
  }
  return best;
}

}  // namespace

std::vector<CorrelationPeak> CorrelateAngularRates(const GyroIntegration& gyro,
                                                   const std::vector<TimedPose>& poses,
                                                   const std::optional<Eigen::Quaterniond>& R_guess,
                                                   double largest_offset) {
  std::vector<RateInterval> intervals = LidarRates(poses);
  std::vector<double> offsets;
  const int half = static_cast<int>(std::ceil(largest_offset / kGridStep));
  for (int i = -half; i <= half; ++i) offsets.push_back(i * kGridStep);

  // Jumps of the odometry are faster than anything that the IMU saw: without them, the first round finds the
  // peak.
  double fastest = 0.0;
  for (const double time : gyro.times()) fastest = std::max(fastest, gyro.AngularVelocity(time).norm());
  for (RateInterval& interval : intervals) {
    if (interval.rate.norm() > 1.5 * fastest + 0.1) interval.weight = 0.0;
  }
  std::vector<Pairing> pairings = Scan(gyro, intervals, R_guess, offsets);
  for (int round = 0; round < 2; ++round) {
    const std::size_t best = Highest(pairings);
    if (pairings[best].count < kFewestIntervals) return {};
    Reweight(gyro, offsets[best], pairings[best], &intervals);
    pairings = Scan(gyro, intervals, R_guess, offsets);
  }

  std::vector<CorrelationPeak> peaks;
  for (std::size_t i = 0; i < pairings.size(); ++i) {
    const double here = pairings[i].correlation;
    const double before = i > 0 ? pairings[i - 1].correlation : here;
    const double after = i + 1 < pairings.size() ? pairings[i + 1].correlation : here;
    if (here <= 0.0 || here < before || here < after) continue;
    const double curvature = before - 2.0 * here + after;
    const double shift = curvature < 0.0 ? 0.5 * (before - after) / curvature : 0.0;
    peaks.push_back({offsets[i] + kGridStep * shift, here, pairings[i].R_imu_lidar});
  }
  std::stable_sort(peaks.begin(), peaks.end(), [](const CorrelationPeak& a, const CorrelationPeak& b) {
    return a.correlation > b.correlation;
  });
  return peaks;
}

}  // namespace mlic
