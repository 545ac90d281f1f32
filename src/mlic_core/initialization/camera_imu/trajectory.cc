#include "mlic_core/initialization/camera_imu/trajectory.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/initialization/pose_fit.h"

namespace mlic {
namespace {

// from: guard, half of the finest knots.
constexpr double kStep = 0.02;  // s, between the poses that the spline is drawn to
constexpr double kPoseRotationSigma =
    2e-3;  // rad, of these poses; from: measured, with kPart (camera_imu.cc)
constexpr double kPoseTranslationSigma = 5e-3;  // m; from: measured, with kPart (camera_imu.cc)

// Turns the gyro frame upright at the time of each gravity, with as little turning between them as can be.
std::vector<Eigen::Quaterniond> UprightTurns(const std::vector<Eigen::Vector3d>& gravity) {
  std::vector<Eigen::Quaterniond> turns;
  Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
  for (const Eigen::Vector3d& g : gravity) {
    before = (Eigen::Quaterniond::FromTwoVectors(before * g, kGravity) * before).normalized();
    turns.push_back(before);
  }
  return turns;
}

std::vector<TimedPose> UprightPoses(const GyroIntegration& gyro, const DrivePositions& drive) {
  std::vector<Eigen::Quaterniond> turns = UprightTurns(drive.gravity);
  // About the observations: beyond, positions are the accelerometer's alone. from: measured, with kPart
  // (camera_imu.cc).
  constexpr double kMargin = 0.5;  // s
  const double start = std::max(gyro.Start(), drive.start - kMargin);
  const double end = std::min(gyro.End(), drive.end + kMargin);
  const Eigen::Vector3d x_axis = turns.front() * gyro.RotationTo(start) * Eigen::Vector3d::UnitX();
  const Eigen::Quaterniond level(
      Eigen::AngleAxisd(-std::atan2(x_axis.y(), x_axis.x()), Eigen::Vector3d::UnitZ()));
  const double length = drive.gravity_times[1] - drive.gravity_times[0];
  const int last = static_cast<int>(turns.size()) - 2;
  const auto turn_at = [&](double time) {
    const int i = std::clamp(static_cast<int>((time - drive.gravity_times[0]) / length), 0, last);
    return Eigen::Quaterniond(level * turns[i].slerp((time - drive.gravity_times[i]) / length, turns[i + 1]));
  };
  const auto position = [&](double t) {
    return drive.positions.Position(SplineBasis(drive.positions.knots(), t));
  };
  std::vector<TimedPose> poses;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  const int steps = static_cast<int>((end - start) / kStep);
  for (int k = 0; k <= steps; ++k) {
    const double t = start + k * kStep;
    if (k > 0) at += turn_at(t - 0.5 * kStep) * (position(t) - position(t - kStep));
    poses.push_back({t, {(turn_at(t) * gyro.RotationTo(t)).normalized(), at}});
  }
  return poses;
}

const TimedPose& Nearest(const std::vector<TimedPose>& poses, double time) {
  const double index = std::round((time - poses.front().time) / kStep);
  return poses[static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(poses.size() - 1)))];
}

}  // namespace

DriveState UprightTrajectory(const Drive& drive, const GyroIntegration& gyro,
                             const Eigen::Vector3d& gyroscope_bias, const DrivePositions& positions,
                             const KnotSpacing& spacing, const ImuSigma& imu_sigma) {
  const std::vector<TimedPose> poses = UprightPoses(gyro, positions);
  const double start = poses.front().time, end = poses.back().time;
  const UniformKnots rotation_knots = UniformKnots::Covering(start, end, spacing.rotation);
  const UniformKnots position_knots = UniformKnots::Covering(start, end, spacing.position);
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> translations;
  for (int j = 0; j < rotation_knots.count; ++j) {
    rotations.push_back(Nearest(poses, rotation_knots.ControlPointTime(j)).pose.rotation);
  }
  for (int j = 0; j < position_knots.count; ++j) {
    translations.push_back(Nearest(poses, position_knots.ControlPointTime(j)).pose.translation);
  }
  return FitToPoses(drive, imu_sigma, poses, kPoseRotationSigma, kPoseTranslationSigma,
                    {{So3Spline(rotation_knots, rotations), PositionSpline(position_knots, translations)},
                     {gyroscope_bias, positions.accelerometer_bias}});
}

}  // namespace mlic
