#include "mlic_core/sensors/imu_matrices.h"

#include <Eigen/LU>

namespace mlic {

RotationAndTriangle SplitAccelerometerMatrix(const Eigen::Matrix3d& matrix) {
  RotationAndTriangle parts;
  // The last column has one axis alone, the one before it that and another.
  parts.rotation.col(2) = matrix.col(2).normalized();
  const Eigen::Vector3d second =
      matrix.col(1) - parts.rotation.col(2) * parts.rotation.col(2).dot(matrix.col(1));
  parts.rotation.col(1) = second.normalized();
  parts.rotation.col(0) = parts.rotation.col(1).cross(parts.rotation.col(2));
  parts.triangle = (parts.rotation.transpose() * matrix).triangularView<Eigen::Lower>();
  return parts;
}

RotationAndTriangle SplitGyroscopeMatrix(const Eigen::Matrix3d& matrix) {
  // The inverse is a rotation times a triangle, as an accelerometer's.
  const RotationAndTriangle inverse = SplitAccelerometerMatrix(matrix.inverse());
  return {inverse.rotation.transpose(), inverse.triangle.inverse()};
}

Eigen::Quaterniond TwistAbout(const Eigen::Matrix3d& directions, const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond twist(rotation);
  twist.vec() = Eigen::Vector3d(directions * twist.vec());
  return twist.normalized();
}

Eigen::Matrix3d ProjectorOn(const std::vector<Eigen::Vector3d>& directions) {
  Eigen::Matrix3d projector = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& direction : directions) projector += direction * direction.transpose();
  return projector;
}

}  // namespace mlic
