#include "mlic_core/lidar/odometry.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/lidar/deskew.h"
#include "mlic_core/lidar/registration.h"
#include "mlic_core/lidar/voxel_hash_map.h"

namespace mlic {
namespace {

constexpr std::size_t kStartScans = 5;   // registered twice, for the velocity in the first scan
constexpr double kForgetting = 0.9;      // of the running errors, for one scan
constexpr double kLeastNoise = 0.01;     // m
constexpr double kMostNoise = 0.1;       // m
constexpr std::size_t kPruneEvery = 50;  // scans

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
  Odometry(double usual_range, const RotationBetween& rotation_between)
      : usual_range_(usual_range),
        rotation_between_(rotation_between),
        map_(std::clamp(usual_range / 15.0, 0.8, 2.0)) {}

  // twist: a first guess of the velocity in the next scan.
  void SetTwist(const Twist& twist) { state_.twist = twist; }
  const Twist& twist() const { return state_.twist; }

  OdometryPose Register(const LidarScan& raw) {
    const PreparedScan scan = Prepare(raw);
    OdometryPose pose;
    pose.time = scan.middle;
    std::optional<ScanMotion> rotation;
    if (rotation_between_) rotation.emplace(rotation_between_, scan.middle, scan.half_span);
    if (scans_ > 0) {
      const MotionPrior prior = Predict(scan, rotation ? &*rotation : nullptr);
      const double reach = 3.0 * (translation_error_.Value() + 0.5 * usual_range_ * rotation_error_.Value());
      const RegistrationResult result =
          RegisterScan(scan.points, scan.half_span, map_, prior, std::min(reach, 2.0), noise_);
      pose.residual_rms = result.residual_rms;
      pose.inlier_share = result.inlier_share;
      Learn(prior, result);
    } else {
      pose.inlier_share = scan.points.empty() ? 0.0 : 1.0;
    }
    pose.pose = state_.pose;
    last_middle_ = scan.middle;
    AddToMap(scan, rotation ? &*rotation : nullptr);
    ++scans_;
    return pose;
  }

 private:
  MotionPrior Predict(const PreparedScan& scan, const ScanMotion* rotation) const {
    MotionPrior prior;
    prior.previous = state_;
    prior.interval = std::max(1e-3, scan.middle - last_middle_);
    prior.rotation = rotation;
    const Eigen::Quaterniond turned = rotation != nullptr
                                          ? rotation_between_(last_middle_, scan.middle)
                                          : ExpQuaternion(prior.interval * state_.twist.angular);
    prior.predicted.pose.rotation = (state_.pose.rotation * turned).normalized();
    prior.predicted.pose.translation =
        state_.pose.translation + prior.interval * (state_.pose.rotation * state_.twist.linear);
    prior.predicted.twist.angular = state_.twist.angular;
    prior.predicted.twist.linear = turned.conjugate() * state_.twist.linear;
    prior.sigma_angular_velocity = 2.0 * angular_velocity_change_.Value();
    prior.sigma_linear_velocity = 2.0 * linear_velocity_change_.Value();
    // Over an interval in which the velocity changes by c, its mean is wrong by about c / 12 (constant jerk).
    prior.sigma_rotation = rotation != nullptr ? 5e-3 : prior.interval * prior.sigma_angular_velocity / 6.0;
    prior.sigma_translation = prior.interval * prior.sigma_linear_velocity / 6.0;
    return prior;
  }

  void Learn(const MotionPrior& prior, const RegistrationResult& result) {
    state_ = result.state;
    angular_velocity_change_.Add((state_.twist.angular - prior.predicted.twist.angular).norm() /
                                 std::sqrt(3.0));
    linear_velocity_change_.Add((state_.twist.linear - prior.predicted.twist.linear).norm() / std::sqrt(3.0));
    rotation_error_.Add(AngleBetween(prior.predicted.pose.rotation, state_.pose.rotation));
    translation_error_.Add((prior.predicted.pose.translation - state_.pose.translation).norm());
    if (result.residual_rms > 0.0) {
      noise_ = std::clamp(kForgetting * noise_ + (1.0 - kForgetting) * result.residual_rms, kLeastNoise,
                          kMostNoise);
    }
  }

  void AddToMap(const PreparedScan& scan, const ScanMotion* rotation) {
    ScanMotion motion = rotation != nullptr ? *rotation : ScanMotion(state_.twist, scan.half_span);
    motion.SetLinear(state_.twist.linear);
    std::vector<Eigen::Vector3d> in_odom;
    in_odom.reserve(scan.points.size());
    const Eigen::Matrix3d matrix = state_.pose.rotation.toRotationMatrix();
    for (const TimedPoint& point : scan.points) {
      in_odom.push_back(matrix * motion.ToMiddle(point.position, point.time) + state_.pose.translation);
    }
    map_.Add(in_odom);
    if (scans_ % kPruneEvery == kPruneEvery - 1)
      map_.RemoveFarFrom(state_.pose.translation, 3.0 * usual_range_ + 20.0);
  }

  double usual_range_;
  const RotationBetween& rotation_between_;
  VoxelHashMap map_;
  MotionState state_;
  double last_middle_ = 0.0;
  std::size_t scans_ = 0;
  double noise_ = 0.05;
  RunningError rotation_error_{0.05, 2e-3};          // rad, of the prediction
  RunningError translation_error_{0.3, 0.02};        // m, of the prediction
  RunningError angular_velocity_change_{1.0, 0.05};  // rad/s, from scan to scan
  RunningError linear_velocity_change_{2.0, 0.1};    // m/s
};

}  // namespace

OdometryResult RunOdometry(const LidarRecording& recording, const RotationBetween& rotation_between,
                           const CancellationToken& cancellation,
                           const std::function<void(double fraction)>& on_progress) {
  OdometryResult result;
  result.poses.reserve(recording.scans.size());
  const double usual_range = UsualRange(recording);
  Twist first_twist;
  {
    // The first scan is taken with the velocity of the next ones, or it would enter the map distorted.
    Odometry trial(usual_range, rotation_between);
    for (std::size_t i = 0; i < std::min(kStartScans, recording.scans.size()); ++i) {
      trial.Register(recording.scans[i]);
      if (i == 1) first_twist = trial.twist();
    }
  }
  Odometry odometry(usual_range, rotation_between);
  odometry.SetTwist(first_twist);
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    cancellation.ThrowIfCancelled();
    result.poses.push_back(odometry.Register(recording.scans[i]));
    if (on_progress) on_progress(static_cast<double>(i + 1) / static_cast<double>(recording.scans.size()));
  }
  return result;
}

}  // namespace mlic
