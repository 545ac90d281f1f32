#pragma once

#include <optional>

#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

// The model behind Project and Unproject (camera_model.h), with their contracts; `parameters` in the order of
// CameraModel.

// x' = x N/D + tangential terms on the normalised plane, N = 1 + k1 s + k2 s^2 + k3 s^3,
// D = 1 + k4 s + k5 s^2 + k6 s^3, s = x^2 + y^2; plumb_bob has D = 1. As in OpenCV's calib3d.
bool ProjectPinhole(const double* parameters, bool rational, const Eigen::Vector3d& point,
                    Eigen::Vector2d* pixel, CameraPointJacobian* J_point,
                    CameraParameterJacobian* J_parameters);
bool UnprojectPinhole(const double* parameters, bool rational, const Eigen::Vector2d& pixel,
                      Eigen::Vector3d* bearing);

// How much more a lens magnifies at an angle theta from its optical axis than along it: log(d rho / d theta /
// f) with rho = f r N/D, r = tan(theta). It goes to minus infinity where the lens folds over, to infinity at
// a pole of N/D, and is 0 everywhere for an equidistant projection. Tangential terms do not take part.
struct Magnification {
  double log = 0.0;
  Eigen::Matrix<double, kMostCameraParameters, 1> gradient;  // by the parameters, at the same angle
};
// At the angle that is seen at this radius of the image (px). Nothing where the lens folds over before it.
std::optional<Magnification> PinholeMagnification(const double* parameters, bool rational, double radius);

}  // namespace mlic
