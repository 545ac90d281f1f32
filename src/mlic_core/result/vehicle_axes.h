#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mlic_core/result/result.h"

namespace mlic {

// R_vehicle_imu: x forward where the rig goes and z up against gravity, in the mean over the first drive; the
// IMU's own axes where the drive shows neither, the root's where nothing is tied to the IMU.
inline Eigen::Matrix3d VehicleAxes(const CalibrationResult& result) {
  constexpr double kNotable =
      1.0;  // m/s, speed at which a vehicle's front is where it goes; from: structural
  if (!result.root.empty() || result.trajectories.empty()) return Eigen::Matrix3d::Identity();
  const std::vector<StampedPose>& poses = result.trajectories[0];
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Quaterniond R_imu_map = poses[i].pose.rotation.conjugate();
    up += R_imu_map * Eigen::Vector3d::UnitZ();
    velocity += R_imu_map * (poses[i].pose.translation - poses[i - 1].pose.translation);
  }
  if (poses.size() < 2 || up.norm() < 0.5 * static_cast<double>(poses.size())) {
    return Eigen::Matrix3d::Identity();
  }
  up.normalize();
  velocity /= SecondsSince(poses.front().time, poses.back().time);
  Eigen::Vector3d forward = velocity - up * up.dot(velocity);
  if (forward.norm() < kNotable) {
    // The axis of the IMU that lies flattest, positive.
    Eigen::Index flattest = 0;
    up.cwiseAbs().minCoeff(&flattest);
    forward = Eigen::Vector3d::Unit(flattest) - up * up[flattest];
  }
  forward.normalize();
  Eigen::Matrix3d R;
  R << forward.transpose(), up.cross(forward).transpose(), up.transpose();
  return R;
}

}  // namespace mlic
