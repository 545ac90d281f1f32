#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// Projection models with ROS' names (sensor_msgs/CameraInfo's distortion_model, and double_sphere).
enum class CameraModel { kPlumbBob, kRationalPolynomial, kEquidistant, kDoubleSphere };

constexpr int kMostCameraParameters = 12;  // from: structural, fx fy cx cy and 8 of rational_polynomial

// Intrinsics of one camera. Pixels; a pixel's centre is at integer coordinates.
struct CameraIntrinsics {
  CameraModel model = CameraModel::kPlumbBob;
  int width = 0;
  int height = 0;
  std::vector<double> parameters;
};

using CameraPointJacobian = Eigen::Matrix<double, 2, 3>;
using CameraParameterJacobian = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMostCameraParameters>;

}  // namespace mlic
