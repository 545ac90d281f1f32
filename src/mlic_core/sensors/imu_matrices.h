#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

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

// The part of a rotation that is about the directions of a projector (swing-twist decomposition).
Eigen::Quaterniond TwistAbout(const Eigen::Matrix3d& directions, const Eigen::Matrix3d& rotation);

// Onto what unit vectors at right angles span.
Eigen::Matrix3d ProjectorOn(const std::vector<Eigen::Vector3d>& directions);

}  // namespace mlic
