#pragma once

#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

// The model behind Project and Unproject (camera_model.h), with their contracts; `parameters` in the order of
// CameraModel.

// Usenko, Demmel and Cremers, "The double sphere camera model", 3DV 2018.
bool ProjectDoubleSphere(const double* parameters, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                         CameraPointJacobian* J_point, CameraParameterJacobian* J_parameters);
bool UnprojectDoubleSphere(const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d* bearing);

}  // namespace mlic
