#include "mlic_core/calibration/result_assembly.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/calibration/refinement.h"

namespace mlic {
namespace {

// T_map_normalised: the first pose of the IMU at the origin, looking along with yaw zero.
RigidTransform MapOrigin(const SplitSpline& trajectory) {
  const RigidTransform first = trajectory.Pose(trajectory.Start());
  const Eigen::Vector3d x_axis = first.rotation * Eigen::Vector3d::UnitX();
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(-std::atan2(x_axis.y(), x_axis.x()), Eigen::Vector3d::UnitZ()));
  return {turn, -(turn * first.translation)};
}

std::vector<StampedPose> SampleTrajectory(const Drive& drive, const SplitSpline& trajectory,
                                          const RigidTransform& origin, double period) {
  std::vector<StampedPose> poses;
  const int count = static_cast<int>(std::floor((trajectory.End() - trajectory.Start()) / period)) + 1;
  for (int k = 0; k < count; ++k) {
    const double t = trajectory.Start() + k * period;
    poses.push_back({TimeFrom(drive.epoch, t), origin * trajectory.Pose(t)});
  }
  return poses;
}

std::vector<MapPoint> SampleMap(const CalibrationState& state, const PlaneAssociation& planes,
                                const RigidTransform& origin, std::size_t largest) {
  const SplitSpline& trajectory = state.drives[0].trajectory;
  const std::size_t stride = std::max<std::size_t>(1, (planes.observations.size() + largest - 1) / largest);
  std::vector<MapPoint> points;
  std::size_t plane = 0;
  for (std::size_t k = 0; k < planes.observations.size(); k += stride) {
    while (planes.begin[plane + 1] <= k) ++plane;
    const PlaneObservation& o = planes.observations[k];
    const double t = o.time + state.lidars[o.lidar].time_offset;
    if (!trajectory.Contains(t)) continue;
    MapPoint point;
    point.position =
        (origin * (trajectory.Pose(t) * (state.lidars[o.lidar].T_imu_sensor * o.position.cast<double>())))
            .cast<float>();
    point.intensity = o.intensity;
    point.lidar = o.lidar;
    point.plane = static_cast<int>(plane);
    points.push_back(point);
  }
  return points;
}

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

double PeakMemoryMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024.0;
}

SensorResult MakeSensor(const LidarConfig& lidar, const SensorCalibration& calibration,
                        const ObservabilityAnalysis& analysis, std::size_t l) {
  SensorResult sensor;
  sensor.name = lidar.name;
  sensor.type = SensorResult::Type::kLidar;
  sensor.frame_id = lidar.frame_id.empty() ? lidar.name : lidar.frame_id;
  sensor.calibration = calibration;
  sensor.sigma = analysis.sigmas[l];
  sensor.translation_observable = analysis.sensors[l].translation;
  sensor.rotation_observable = analysis.sensors[l].rotation;
  sensor.time_offset_observable = analysis.sensors[l].time_offset;
  sensor.unobservable = analysis.sensors[l].directions;
  return sensor;
}

// Reasons for refusal of one LiDAR; none when its result may be trusted.
std::vector<std::string> Judge(const LidarConfig& lidar, const ObservabilityAnalysis::Sensor& sensor) {
  std::vector<std::string> reasons;
  const auto all = [](const std::array<bool, 3>& axes) { return axes[0] && axes[1] && axes[2]; };
  if (!all(sensor.rotation)) {
    reasons.push_back(lidar.name +
                      ": the motion does not show its whole rotation to 0.5 deg; turn about more axes");
  }
  if (!sensor.time_offset) {
    reasons.push_back(lidar.name +
                      ": the motion does not show its time offset to 5 ms; turn more, and not evenly");
  }
  bool translation_shown = all(sensor.translation);
  for (const UnobservableDirection& direction : sensor.directions) {
    translation_shown &= direction.quantity != UnobservableDirection::Quantity::kTranslation;
  }
  if (!translation_shown && !lidar.guess) {
    reasons.push_back(lidar.name +
                      ": the motion does not show its whole translation to 5 cm, and the rig file gives no "
                      "T_imu_sensor to hold; measure it by hand, or turn about more axes");
  }
  return reasons;
}

}  // namespace

std::size_t ImuSampleCount(const Dataset& dataset) {
  std::size_t count = 0;
  for (const Drive& drive : dataset.drives) count += drive.imu.size();
  return count;
}

void FinishRefused(CalibrationResult* result) {
  result->trusted = false;
  result->peak_memory_megabytes = PeakMemoryMegabytes();
}

void AssembleResult(const Rig& rig, const Dataset& dataset, const Refinement& refinement,
                    CalibrationResult* result) {
  const CalibrationState& state = refinement.state();
  const ObservabilityAnalysis analysis = refinement.Analyze();
  std::vector<bool> shown;
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    const auto reasons =
        rig.lidars[l].fixed ? std::vector<std::string>() : Judge(rig.lidars[l], analysis.sensors[l]);
    shown.push_back(reasons.empty());
    result->reasons.insert(result->reasons.end(), reasons.begin(), reasons.end());
  }
  if (refinement.problem().planes[0].planes.size() < 20) {
    result->reasons.push_back("the map has hardly any planes; record near buildings or in a furnished hall");
  }
  if (!refinement.converged()) {
    result->warnings.push_back(
        "the calibration still moved by more than a tenth of its sigma in the last round");
  }
  result->trusted = result->reasons.empty();
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    if (shown[l]) result->sensors.push_back(MakeSensor(rig.lidars[l], state.lidars[l], analysis, l));
  }
  for (std::size_t a = 0; a < rig.lidars.size(); ++a) {
    for (std::size_t b = a + 1; b < rig.lidars.size(); ++b) {
      Eigen::Matrix<double, 14, 14> covariance, data;
      const auto gather = [&](const Eigen::MatrixXd& from, Eigen::Matrix<double, 14, 14>* to) {
        *to << from.block<7, 7>(7 * a, 7 * a), from.block<7, 7>(7 * a, 7 * b), from.block<7, 7>(7 * b, 7 * a),
            from.block<7, 7>(7 * b, 7 * b);
      };
      gather(analysis.covariance, &covariance);
      gather(analysis.data_covariance, &data);
      PairResult pair = MakePair(state.lidars[a], state.lidars[b], covariance);
      const PoseSigma from_data = MakePair(state.lidars[a], state.lidars[b], data).sigma;
      const bool pair_shown =
          from_data.translation.maxCoeff() < 0.05 && from_data.rotation.maxCoeff() < 0.5 * M_PI / 180.0;
      if (!pair_shown && !(shown[a] && shown[b])) continue;
      pair.a = rig.lidars[a].name;
      pair.b = rig.lidars[b].name;
      result->pairs.push_back(pair);
    }
  }
  result->imu = state.Imu(0);
  result->gravity = kGravity;
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const SplitSpline& trajectory = state.drives[d].trajectory;
    result->trajectories.push_back(
        SampleTrajectory(dataset.drives[d], trajectory, MapOrigin(trajectory), 0.01));
  }
  result->map =
      SampleMap(state, refinement.problem().planes[0], MapOrigin(state.drives[0].trajectory), 2000000);
  result->residuals = SummarizeResiduals(rig, dataset, refinement);
  result->peak_memory_megabytes = PeakMemoryMegabytes();
}

CalibrationSnapshot MakeSnapshot(const std::string& stage, int iteration, const Rig& rig,
                                 const Dataset& dataset, const CalibrationState& state,
                                 const PlaneAssociation& planes, const std::vector<PoseSigma>& sigmas,
                                 double cost) {
  CalibrationSnapshot snapshot;
  snapshot.stage = stage;
  snapshot.iteration = iteration;
  snapshot.cost = cost;
  for (const LidarConfig& lidar : rig.lidars) {
    snapshot.sensor_names.push_back(lidar.name);
    snapshot.sensor_frames.push_back(lidar.frame_id.empty() ? lidar.name : lidar.frame_id);
  }
  snapshot.sensors = state.lidars;
  snapshot.sigmas = sigmas;
  const RigidTransform origin = MapOrigin(state.drives[0].trajectory);
  snapshot.trajectory = SampleTrajectory(dataset.drives[0], state.drives[0].trajectory, origin, 0.1);
  snapshot.points = SampleMap(state, planes, origin, 100000);
  for (const MapPlane& plane : planes.planes) {
    snapshot.planes.push_back({origin * plane.center, origin.rotation * plane.plane.normal,
                               origin.rotation * plane.axis_u, origin.rotation * plane.axis_v});
  }
  return snapshot;
}

}  // namespace mlic
