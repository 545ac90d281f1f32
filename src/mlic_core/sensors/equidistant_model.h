#pragma once

#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

// The model behind Project and Unproject (camera_model.h), with their contracts; `parameters` in the order of
// CameraModel.

// Kannala and Brandt, 2006: the radius is theta (1 + k1 theta^2 + .. + k4 theta^8), theta the angle from the
// axis in [0, pi).
bool ProjectEquidistant(const double* parameters, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                        CameraPointJacobian* J_point, CameraParameterJacobian* J_parameters);
bool UnprojectEquidistant(const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d* bearing);

}  // namespace mlic
