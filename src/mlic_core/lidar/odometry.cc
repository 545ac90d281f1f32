#include "mlic_core/lidar/odometry.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/lidar/deskew.h"
#include "mlic_core/lidar/registration.h"
#include "mlic_core/lidar/voxel_hash_map.h"

namespace mlic {
namespace {

// from: guard, time.
constexpr std::size_t kStartScans = 5;  // registered twice, for the velocity in the first scan
// from: measured, drift of simulated drives by hand and car.
constexpr double kForgetting = 0.9;   // of the running errors, for one scan
constexpr double kLeastNoise = 0.01;  // m; from: guard
constexpr double kMostNoise = 0.1;    // m; from: guard, LiDARs err by some centimetres
// from: measured, drift of simulated drives by hand and car.
constexpr double kGyroscopeSigma = 3e-3;    // rad, over one scan period
constexpr double kAccelerationSigma = 0.2;  // m/s^2; from: guard, biases and tilts
constexpr double kFarthestSearch = 2.0;     // m; from: guard, the largest voxel
constexpr std::size_t kPruneEvery = 50;     // scans; from: structural, memory only
constexpr double kNewPlace = 0.02;  // m; from: guard, between noise of poses and motion from scan to scan
// from: guard, between noise of poses and motion from scan to scan.
constexpr double kNewDirection = 4e-3;  // rad

// The points of a scan with times after its middle.
struct PreparedScan {
  double middle = 0.0;     // s since the drive's epoch
  double half_span = 0.0;  // s
  std::vector<TimedPoint> points;
};

PreparedScan Prepare(const LidarScan& scan) {
  PreparedScan prepared;
  prepared.middle = scan.time;
  if (scan.points.empty()) return prepared;
  const double first = scan.points.front().time;
  const double last = scan.points.back().time;
  prepared.middle = scan.time + 0.5 * (first + last);
  prepared.half_span = 0.5 * (last - first);
  prepared.points.reserve(scan.points.size());
  for (const LidarPoint& point : scan.points) {
    prepared.points.push_back({point.position.cast<double>(), point.time - 0.5 * (first + last)});
  }
  return prepared;
}

// Range that nine tenths of the points do not exceed, over some scans of the recording.
double UsualRange(const LidarRecording& recording) {
  std::vector<float> ranges;
  const std::size_t step = std::max<std::size_t>(1, recording.scans.size() / 10);
  for (std::size_t i = 0; i < recording.scans.size(); i += step) {
    for (const LidarPoint& point : recording.scans[i].points) ranges.push_back(point.position.norm());
  }
  if (ranges.empty()) return 20.0;
  const auto place = ranges.begin() + ranges.size() * 9 / 10;
  std::nth_element(ranges.begin(), place, ranges.end());
  return *place;
}

// A running root mean square with a floor.
class RunningError {
 public:
  RunningError(double first, double floor) : square_(first * first), floor_(floor) {}
  void Add(double error) { square_ = kForgetting * square_ + (1.0 - kForgetting) * error * error; }
  double Value() const { return std::max(floor_, std::sqrt(square_)); }

 private:
  double square_;
  double floor_;
};

class Odometry {
 public:
  // remembered: how many scans the map holds at most.
  Odometry(double usual_range, const InertialMotion& inertial, std::size_t remembered)
      : usual_range_(usual_range), inertial_(inertial), remembered_(remembered), map_(Voxel()) {}

  // twist: a first guess of the velocity in the next scan.
  void SetTwist(const Twist& twist) { state_.twist = twist; }

  TimedPose Register(const LidarScan& raw) {
    const PreparedScan scan = Prepare(raw);
    std::optional<ScanMotion> rotation;
    if (KnowsRotation(scan)) rotation.emplace(inertial_.rotation, scan.middle, scan.half_span);
    if (scans_ == 0) {
      ScanMotion motion =
          rotation ? *rotation : ScanMotion(state_.twist, Eigen::Vector3d::Zero(), scan.half_span);
      motion.SetLinear(state_.twist.linear);
      AddToMap(scan, motion);
    } else {
      const MotionPrior prior = Predict(scan, rotation ? &*rotation : nullptr);
      const double reach = 3.0 * (translation_error_.Value() + 0.5 * usual_range_ * rotation_error_.Value());
      const RegistrationResult result =
          RegisterScan(scan.points, scan.half_span, map_, prior, std::min(reach, kFarthestSearch), noise_);
      Learn(prior, result);
      if (IsNewView()) AddToMap(scan, MotionDuring(state_, prior, scan.half_span));
    }
    last_middle_ = scan.middle;
    ++scans_;
    return {scan.middle, state_.pose};
  }

 private:
  // Of the whole scan and since the one before.
  bool KnowsRotation(const PreparedScan& scan) const {
    if (!inertial_.rotation) return false;
    constexpr double kSlack = 1e-3;  // s; from: guard, rounding of stamps
    const double begin = scan.middle - scan.half_span - kSlack;
    const double end = scan.middle + scan.half_span + kSlack;
    return inertial_.rotation(scans_ == 0 ? begin : std::min(begin, last_middle_), end).has_value();
  }

  MotionPrior Predict(const PreparedScan& scan, const ScanMotion* rotation) const {
    MotionPrior prior;
    prior.previous = state_.pose;
    prior.interval = std::max(1e-3, scan.middle - last_middle_);
    prior.rotation = rotation;
    const Eigen::Quaterniond turned = rotation != nullptr
                                          ? inertial_.rotation(last_middle_, scan.middle).value()
                                          : ExpQuaternion(prior.interval * state_.twist.angular);
    prior.predicted.pose.rotation = (state_.pose.rotation * turned).normalized();
    const Eigen::Quaterniond& R = state_.pose.rotation;
    prior.predicted.pose.translation = state_.pose.translation + prior.interval * (R * state_.twist.linear);
    prior.predicted.twist = {state_.twist.angular, turned.conjugate() * state_.twist.linear};
    const bool accelerated = rotation != nullptr && inertial_.gain;
    if (accelerated) {
      const double T = prior.interval;
      const LinearGain gain = inertial_.gain(last_middle_, scan.middle);
      prior.predicted.pose.translation += R * gain.position + 0.5 * T * T * inertial_.gravity;
      prior.predicted.twist.linear +=
          turned.conjugate() * (gain.velocity + T * (R.conjugate() * inertial_.gravity));
      prior.velocity_gain = R * (gain.velocity - gain.position / T) + 0.5 * T * inertial_.gravity;
    }
    prior.velocity_before = velocity_;
    prior.extrapolation = scans_ > 1 ? prior.interval / (prior.interval + last_interval_) : 0.0;
    // After a gap the prediction is worse, as the square of the time.
    const double gap = scans_ > 1 ? std::max(1.0, prior.interval / last_interval_) : 1.0;
    prior.sigma_angular_velocity = angular_jerk_.Value();
    prior.sigma_linear_velocity = accelerated ? kAccelerationSigma * prior.interval : linear_jerk_.Value();
    prior.sigma_rotation = rotation != nullptr ? kGyroscopeSigma : 3.0 * gap * gap * rotation_error_.Value();
    prior.sigma_translation = 3.0 * gap * gap * translation_error_.Value();
    return prior;
  }

  void Learn(const MotionPrior& prior, const RegistrationResult& result) {
    state_ = result.state;
    const MeanVelocity velocity = VelocityBetween(prior.previous, state_.pose, prior.interval);
    const MeanVelocity change{velocity.angular - velocity_.angular, velocity.linear - velocity_.linear};
    if (scans_ > 2) {
      angular_jerk_.Add((change.angular - change_.angular).norm());
      linear_jerk_.Add((change.linear - change_.linear).norm());
    }
    velocity_ = velocity;
    change_ = change;
    last_interval_ = prior.interval;
    rotation_error_.Add(AngleBetween(prior.predicted.pose.rotation, state_.pose.rotation));
    translation_error_.Add((prior.predicted.pose.translation - state_.pose.translation).norm());
    if (result.residual_rms > 0.0) {
      noise_ = std::clamp(kForgetting * noise_ + (1.0 - kForgetting) * result.residual_rms, kLeastNoise,
                          kMostNoise);
    }
  }

  // Scans from one place hold the same few lines of a sparse LiDAR over and over. A map full of them, as
  // after a stand of seconds, would hold the pose back when the LiDAR starts to move.
  bool IsNewView() const {
    return (state_.pose.translation - last_added_.translation).norm() > kNewPlace ||
           AngleBetween(state_.pose.rotation, last_added_.rotation) > kNewDirection;
  }

  void AddToMap(const PreparedScan& scan, const ScanMotion& motion) {
    last_added_ = state_.pose;
    std::vector<Eigen::Vector3d> in_odom;
    in_odom.reserve(scan.points.size());
    const Eigen::Matrix3d matrix = state_.pose.rotation.toRotationMatrix();
    for (const TimedPoint& point : scan.points) {
      in_odom.push_back(matrix * motion.ToMiddle(point.position, point.time) + state_.pose.translation);
    }
    map_.Add(in_odom);
    if (++added_ % kPruneEvery == 0) map_.RemoveFarFrom(state_.pose.translation, 3.0 * usual_range_ + 20.0);
    if (remembered_ == kAllScans) return;
    recent_.push_back(std::move(in_odom));
    if (recent_.size() <= remembered_) return;
    recent_.erase(recent_.begin(), recent_.begin() + static_cast<std::ptrdiff_t>(remembered_ / 2));
    map_ = VoxelHashMap(Voxel());
    for (const std::vector<Eigen::Vector3d>& points : recent_) map_.Add(points);
  }

  double Voxel() const { return std::clamp(usual_range_ / 15.0, 0.8, 2.0); }

  double usual_range_;
  const InertialMotion& inertial_;
  std::size_t remembered_;
  VoxelHashMap map_;
  std::vector<std::vector<Eigen::Vector3d>> recent_;  // scans of the map, where it forgets; in its frame
  MotionState state_;
  RigidTransform last_added_;  // pose of the last scan that went into the map
  double last_middle_ = 0.0;
  double last_interval_ = 0.1;
  std::size_t scans_ = 0, added_ = 0;
  double noise_ = 0.05;
  RunningError rotation_error_{0.05, 2e-3};    // rad, of the prediction
  RunningError translation_error_{0.3, 0.02};  // m, of the prediction
  MeanVelocity velocity_;                      // since the scan before
  MeanVelocity change_;                        // of velocity_ from the one before
  RunningError angular_jerk_{0.5, 0.01};       // rad/s, change of change_
  RunningError linear_jerk_{1.0, 0.02};        // m/s
};

// The velocity in the first scan, extrapolated from a trial of the first few. Without it the first scan would
// enter the map distorted.
Twist FirstTwist(const LidarRecording& recording, double usual_range, const InertialMotion& inertial) {
  if (recording.scans.size() < kStartScans) return {};
  Odometry trial(usual_range, inertial, kAllScans);
  std::vector<TimedPose> poses;
  for (std::size_t i = 0; i < kStartScans; ++i) poses.push_back(trial.Register(recording.scans[i]));
  const auto velocity = [&](std::size_t i) {
    return VelocityBetween(poses[i].pose, poses[i + 1].pose,
                           std::max(1e-3, poses[i + 1].time - poses[i].time));
  };
  const MeanVelocity first = velocity(0), second = velocity(1);
  return {1.5 * first.angular - 0.5 * second.angular, 1.5 * first.linear - 0.5 * second.linear};
}

}  // namespace

std::vector<TimedPose> RunOdometry(const LidarRecording& recording, const InertialMotion& inertial,
                                   std::size_t remembered, const CancellationToken& cancellation,
                                   const std::function<void(double fraction)>& on_progress) {
  std::vector<TimedPose> poses;
  poses.reserve(recording.scans.size());
  const double usual_range = UsualRange(recording);
  Odometry odometry(usual_range, inertial, remembered);
  odometry.SetTwist(FirstTwist(recording, usual_range, inertial));
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    cancellation.ThrowIfCancelled();
    poses.push_back(odometry.Register(recording.scans[i]));
    if (on_progress) on_progress(static_cast<double>(i + 1) / static_cast<double>(recording.scans.size()));
  }
  return poses;
}

}  // namespace mlic
