#include "mlic_core/summary/residual_summary.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/problem/imu_terms.h"
#include "mlic_core/problem/landmark_terms.h"
#include "mlic_core/problem/plane_terms.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how the report looks.

constexpr int kHistogramBins = 50;
constexpr int kTimeBins = 60;
constexpr int kFieldCells = 16;  // along the longer side of an image

// Collects whitened residuals in a histogram and their rms over time.
class ResidualCollector {
 public:
  ResidualCollector(std::string sensor, std::string unit, double sigma, double start, double end)
      : start_(start),
        width_((end - start) / kTimeBins),
        squares_(kTimeBins, 0.0),
        sums_(squares_),
        counts_(squares_) {
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
    sums_[at] += whitened;
    counts_[at] += 1.0;
  }
  // The level that residuals with sigmas of their own are shown against.
  void SetSigma(double sigma) { summary_.sigma = sigma; }
  void SetField(ResidualField field) { summary_.over_image = std::move(field); }
  ResidualSummary Finish() {
    summary_.inlier_share = total_ > 0.0 ? inliers_ / total_ : 0.0;
    double squares = 0.0, drift = 0.0, bins = 0.0;
    for (int b = 0; b < kTimeBins; ++b) {
      squares += squares_[b];
      if (counts_[b] == 0.0) continue;
      const double mean = sums_[b] / counts_[b];
      drift += mean * mean - 1.0 / counts_[b];
      bins += 1.0;
      summary_.over_time_seconds.push_back(start_ + (b + 0.5) * width_);
      summary_.over_time_rms.push_back(std::sqrt(squares_[b] / counts_[b]));
    }
    summary_.drift = std::sqrt(std::max(0.0, drift) / std::max(1.0, bins));
    summary_.rms = total_ > 0.0 ? std::sqrt(squares / total_) : 0.0;
    return summary_;
  }

 private:
  ResidualSummary summary_;
  double start_, width_, total_ = 0.0, inliers_ = 0.0;
  std::vector<double> squares_, sums_, counts_;  // of each time bin; sums_: of whitened residuals
};

// Means over time of one of the IMU's sensors along each axis.
class BiasCollector {
 public:
  // sigma: of a sample.
  BiasCollector(const Eigen::Vector3d& sigma, double start, double end)
      : sigma_(sigma),
        start_(start),
        width_((end - start) / kTimeBins),
        sums_(kTimeBins, Eigen::Vector3d::Zero()),
        counts_(kTimeBins, 0.0) {}
  // residual: what is modelled less what was measured; with a bias that is so far from its mean.
  void Add(double time, const Eigen::Vector3d& residual, const Eigen::Vector3d& from_mean) {
    const auto bin =
        static_cast<std::size_t>(std::clamp(static_cast<int>((time - start_) / width_), 0, kTimeBins - 1));
    sums_[bin] += from_mean - residual;
    counts_[bin] += 1.0;
  }
  // Bins are those of the residuals over time.
  void FillIn(ResidualSummary* summary) const {
    for (std::size_t b = 0; b < counts_.size(); ++b) {
      if (counts_[b] == 0.0) continue;
      summary->bias_over_time.push_back(sums_[b] / counts_[b]);
      summary->bias_sigma_over_time.push_back(sigma_ / std::sqrt(counts_[b]));
    }
  }

 private:
  Eigen::Vector3d sigma_;
  double start_, width_;
  std::vector<Eigen::Vector3d> sums_;
  std::vector<double> counts_;
};

// Sums of reprojection errors by cells of the image.
class FieldCollector {
 public:
  FieldCollector(int width, int height) : cell_(static_cast<double>(std::max(width, height)) / kFieldCells) {
    field_.columns = static_cast<int>(std::ceil(width / cell_));
    field_.rows = static_cast<int>(std::ceil(height / cell_));
    field_.counts.assign(static_cast<std::size_t>(field_.columns) * field_.rows, 0);
    sums_.assign(field_.counts.size(), Eigen::Vector2d::Zero());
  }
  void Add(const Eigen::Vector2d& pixel, const Eigen::Vector2d& residual) {
    // Pixel centres are whole numbers: the image begins half a pixel before 0.
    const int column = std::clamp(static_cast<int>((pixel.x() + 0.5) / cell_), 0, field_.columns - 1);
    const int row = std::clamp(static_cast<int>((pixel.y() + 0.5) / cell_), 0, field_.rows - 1);
    const std::size_t at = static_cast<std::size_t>(row) * field_.columns + column;
    sums_[at] += residual;
    ++field_.counts[at];
  }
  ResidualField Finish() {
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      field_.mean.push_back((sums_[i] / std::max(1, field_.counts[i])).cast<float>());
    }
    return field_;
  }

 private:
  double cell_;
  ResidualField field_;
  std::vector<Eigen::Vector2d> sums_;
};

double RootMeanSquare(const std::vector<float>& values) {
  double squares = 0.0;
  for (const float value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace

std::vector<ResidualSummary> SummarizeCameraResiduals(const Rig& rig, const CalibrationState& state,
                                                      const LandmarkSet& landmarks) {
  const SplitSpline& trajectory = state.drives[0].trajectory;
  const std::vector<Eigen::Vector2d> residuals = LandmarkResiduals(landmarks, state, 0);
  std::vector<ResidualSummary> summaries;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const CameraCalibration& camera = state.cameras[c];
    ResidualCollector collector(rig.cameras[c].name, "px", 1.0, trajectory.Start(), trajectory.End());
    FieldCollector field(camera.intrinsics.width, camera.intrinsics.height);
    std::vector<float> sigmas;
    for (std::size_t k = 0; k < residuals.size(); ++k) {
      const LandmarkObservation& o = landmarks.observations[k];
      if (o.camera != static_cast<int>(c) || !residuals[k].allFinite()) continue;
      for (int a = 0; a < 2; ++a) collector.Add(o.time, residuals[k][a], residuals[k][a] / o.sigma);
      field.Add(o.pixel, residuals[k]);
      sigmas.push_back(o.sigma);
    }
    if (sigmas.empty()) continue;
    collector.SetSigma(RootMeanSquare(sigmas));
    collector.SetField(field.Finish());
    summaries.push_back(collector.Finish());
  }
  return summaries;
}

std::vector<ResidualSummary> SummarizeResiduals(const Rig& rig, const Dataset& dataset,
                                                const Adjustment& adjustment) {
  const CalibrationState& state = adjustment.state;
  const SplitSpline& trajectory = state.drives[0].trajectory;
  const DriveTerms& terms = adjustment.problem.drives[0];
  const ImuSigma& imu = terms.imu_sigma.usual;
  const double start = trajectory.Start(), end = trajectory.End();
  std::vector<ResidualCollector> collectors;
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    collectors.emplace_back(rig.lidars[l].name, "m", adjustment.plane_noise[l].Sigma(1.0), start, end);
  }
  const std::vector<float> distances = PlaneResiduals(terms.planes, state, 0);
  for (std::size_t k = 0; k < distances.size(); ++k) {
    const PlaneObservation& o = terms.planes.observations[k];
    collectors[o.lidar].Add(o.time, distances[k], distances[k] / o.sigma);
  }
  ResidualCollector gyroscope("gyroscope", "rad/s", std::sqrt(imu.gyroscope.squaredNorm() / 3.0), start, end);
  ResidualCollector accelerometer("accelerometer", "m/s^2", std::sqrt(imu.accelerometer.squaredNorm() / 3.0),
                                  start, end);
  BiasCollector gyroscope_bias(imu.gyroscope, start, end), accelerometer_bias(imu.accelerometer, start, end);
  const ImuResiduals residuals = EvaluateImuResiduals(dataset, state, 0);
  const BiasCourse& course = state.drives[0].bias;
  const BiasCourse::Bias mean_bias = course.Mean();
  for (std::size_t k = 0; k < residuals.times.size(); ++k) {
    const BiasCourse::Bias from_mean = course.Value(residuals.times[k]) - mean_bias;
    gyroscope_bias.Add(residuals.times[k], residuals.values[k].head<3>(), from_mean.head<3>());
    accelerometer_bias.Add(residuals.times[k], residuals.values[k].tail<3>(), from_mean.tail<3>());
    const ImuSigma sigma = terms.imu_sigma.At(residuals.times[k]);
    for (int a = 0; a < 3; ++a) {
      gyroscope.Add(residuals.times[k], residuals.values[k][a], residuals.values[k][a] / sigma.gyroscope[a]);
      accelerometer.Add(residuals.times[k], residuals.values[k][3 + a],
                        residuals.values[k][3 + a] / sigma.accelerometer[a]);
    }
  }
  std::vector<ResidualSummary> summaries;
  for (ResidualCollector& collector : collectors) summaries.push_back(collector.Finish());
  for (ResidualSummary& summary : SummarizeCameraResiduals(rig, state, terms.landmarks)) {
    summaries.push_back(std::move(summary));
  }
  summaries.push_back(gyroscope.Finish());
  gyroscope_bias.FillIn(&summaries.back());
  summaries.push_back(accelerometer.Finish());
  accelerometer_bias.FillIn(&summaries.back());
  return summaries;
}

}  // namespace mlic
