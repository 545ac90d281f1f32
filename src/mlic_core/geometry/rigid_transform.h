#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace mlic {

// T_a_b: maps points of frame b into frame a, p_a = rotation * p_b + translation. Metres.
struct RigidTransform {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return rotation * p + translation; }

  RigidTransform operator*(const RigidTransform& other) const {
    return {(rotation * other.rotation).normalized(), rotation * other.translation + translation};
  }

  RigidTransform Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {inverse, -(inverse * translation)};
  }
};

}  // namespace mlic
