#pragma once

#include <Eigen/Core>

namespace mlic {

// A 3 x 3 matrix as a rotation and a lower triangle with a positive diagonal.
struct RotationAndTriangle {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d triangle = Eigen::Matrix3d::Identity();
};

// M_a = rotation * triangle (docs/method.md, section 1): how the accelerometer's axes are turned against the
// IMU's, and their scale and shear. The matrix must have full rank.
RotationAndTriangle SplitAccelerometerMatrix(const Eigen::Matrix3d& matrix);

// M_w = triangle * rotation: how the gyroscope's axes are turned against those that a matrix refers to.
// MLIC's own results have one about axes of the IMU that are the accelerometer's alone. The matrix must have
// full rank.
RotationAndTriangle SplitGyroscopeMatrix(const Eigen::Matrix3d& matrix);

}  // namespace mlic
