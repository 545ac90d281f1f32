#pragma once

#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// The models behind Project and Unproject, one pair of functions for each; `parameters` in the order of
// CameraModel. Contracts as of Project and Unproject.

// x' = x N/D + tangential terms on the normalised plane, N = 1 + k1 s + k2 s^2 + k3 s^3,
// D = 1 + k4 s + k5 s^2 + k6 s^3, s = x^2 + y^2; plumb_bob has D = 1. As in OpenCV's calib3d.
bool ProjectPinhole(const double* parameters, bool rational, const Eigen::Vector3d& point,
                    Eigen::Vector2d* pixel, CameraPointJacobian* J_point,
                    CameraParameterJacobian* J_parameters);
bool UnprojectPinhole(const double* parameters, bool rational, const Eigen::Vector2d& pixel,
                      Eigen::Vector3d* bearing);

// Kannala and Brandt, 2006: the radius is theta (1 + k1 theta^2 + .. + k4 theta^8), theta the angle from the
// axis in [0, pi).
bool ProjectEquidistant(const double* parameters, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                        CameraPointJacobian* J_point, CameraParameterJacobian* J_parameters);
bool UnprojectEquidistant(const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d* bearing);

// Usenko, Demmel and Cremers, "The double sphere camera model", 3DV 2018.
bool ProjectDoubleSphere(const double* parameters, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                         CameraPointJacobian* J_point, CameraParameterJacobian* J_parameters);
bool UnprojectDoubleSphere(const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d* bearing);

}  // namespace mlic
