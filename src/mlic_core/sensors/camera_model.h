#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

// Number of parameters: fx fy cx cy, then the distortion in ROS' order
//   plumb_bob            k1 k2 p1 p2 k3                      (9)
//   rational_polynomial  k1 k2 p1 p2 k3 k4 k5 k6             (12)
//   equidistant          k1 k2 k3 k4                         (8)
//   double_sphere        xi alpha                            (6)
int ParameterCount(CameraModel model);

// Names of the parameters in their order.
std::vector<std::string> ParameterNames(CameraModel model);

// The pixel of a point in the camera's optical frame (z forward, x right, y down); any distance, so bearings
// too. False where the model does not hold: behind a pinhole, beyond the monotonic part of its distortion,
// beyond the model's field of view. The pixel may lie outside the image. Jacobians where not null.
bool Project(const CameraIntrinsics& intrinsics, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
             CameraPointJacobian* J_point = nullptr, CameraParameterJacobian* J_parameters = nullptr);

// The unit bearing in the optical frame that a pixel sees; false where there is none.
bool Unproject(const CameraIntrinsics& intrinsics, const Eigen::Vector2d& pixel, Eigen::Vector3d* bearing);

// First intrinsics from the horizontal field of view alone: centre in the middle, equal focal lengths, no
// distortion (double_sphere: xi 0, alpha such that the field of view fits). fov_deg: below 170 for
// plumb_bob and rational_polynomial, up to 260 otherwise; throws InputError beyond.
CameraIntrinsics IntrinsicsFromFieldOfView(CameraModel model, int width, int height, double fov_deg);

}  // namespace mlic
