#include "mlic_core/sensors/imu_matrices.h"

#include <Eigen/Geometry>

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
  RotationAndTriangle parts;
  // The first row has one axis alone, the second that and another.
  parts.rotation.row(0) = matrix.row(0).normalized();
  const Eigen::RowVector3d second =
      matrix.row(1) - parts.rotation.row(0) * parts.rotation.row(0).dot(matrix.row(1));
  parts.rotation.row(1) = second.normalized();
  parts.rotation.row(2) = parts.rotation.row(0).cross(parts.rotation.row(1));
  parts.triangle = (matrix * parts.rotation.transpose()).triangularView<Eigen::Lower>();
  return parts;
}

}  // namespace mlic
