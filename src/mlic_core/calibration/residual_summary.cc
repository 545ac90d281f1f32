#include "mlic_core/calibration/residual_summary.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/calibration/refinement.h"

namespace mlic {
namespace {

constexpr int kHistogramBins = 50;
constexpr int kTimeBins = 60;

// Collects whitened residuals in a histogram and their rms over time.
class ResidualCollector {
 public:
  ResidualCollector(std::string sensor, std::string unit, double sigma, double start, double end)
      : start_(start), width_((end - start) / kTimeBins), squares_(kTimeBins, 0.0), counts_(kTimeBins, 0.0) {
    summary_.sensor = std::move(sensor);
    summary_.unit = std::move(unit);
    summary_.sigma = sigma;
    summary_.histogram.assign(kHistogramBins, 0.0);
  }
  void Add(double time, double residual, double whitened) {
    ++total_;
    if (std::abs(whitened) <= 3.0) ++inliers_;
    const int bin = static_cast<int>(std::floor((whitened + 5.0) / 10.0 * kHistogramBins));
    if (bin >= 0 && bin < kHistogramBins) summary_.histogram[bin] += 1.0;
    const int at = std::clamp(static_cast<int>((time - start_) / width_), 0, kTimeBins - 1);
    squares_[at] += residual * residual;
    counts_[at] += 1.0;
  }
  ResidualSummary Finish() {
    summary_.inlier_share = total_ > 0.0 ? inliers_ / total_ : 0.0;
    for (int b = 0; b < kTimeBins; ++b) {
      if (counts_[b] == 0.0) continue;
      summary_.over_time_seconds.push_back(start_ + (b + 0.5) * width_);
      summary_.over_time_rms.push_back(std::sqrt(squares_[b] / counts_[b]));
    }
    return summary_;
  }

 private:
  ResidualSummary summary_;
  double start_, width_, total_ = 0.0, inliers_ = 0.0;
  std::vector<double> squares_, counts_;
};

}  // namespace

std::vector<ResidualSummary> SummarizeResiduals(const Rig& rig, const Dataset& dataset,
                                                const Refinement& refinement) {
  const CalibrationState& state = refinement.state();
  const SplitSpline& trajectory = state.drives[0].trajectory;
  const ImuSigma& imu = refinement.problem().imu_sigma[0];
  const double start = trajectory.Start(), end = trajectory.End();
  std::vector<ResidualCollector> collectors;
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    collectors.emplace_back(rig.lidars[l].name, "m", refinement.noise()[l].Sigma(1.0), start, end);
  }
  const PlaneAssociation& planes = refinement.problem().planes[0];
  const std::vector<float> distances = PlaneResiduals(planes, state, 0);
  for (std::size_t k = 0; k < distances.size(); ++k) {
    const PlaneObservation& o = planes.observations[k];
    collectors[o.lidar].Add(o.time, distances[k], distances[k] / o.sigma);
  }
  ResidualCollector gyroscope("gyroscope", "rad/s", imu.gyroscope, start, end);
  ResidualCollector accelerometer("accelerometer", "m/s^2", imu.accelerometer, start, end);
  const ImuResiduals residuals = EvaluateImuResiduals(dataset, state, 0);
  for (std::size_t k = 0; k < residuals.times.size(); ++k) {
    for (int a = 0; a < 3; ++a) {
      gyroscope.Add(residuals.times[k], residuals.values[k][a], residuals.values[k][a] / imu.gyroscope);
      accelerometer.Add(residuals.times[k], residuals.values[k][3 + a],
                        residuals.values[k][3 + a] / imu.accelerometer);
    }
  }
  std::vector<ResidualSummary> summaries;
  for (ResidualCollector& collector : collectors) summaries.push_back(collector.Finish());
  summaries.push_back(gyroscope.Finish());
  summaries.push_back(accelerometer.Finish());
  return summaries;
}

}  // namespace mlic
