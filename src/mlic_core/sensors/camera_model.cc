#include "mlic_core/sensors/camera_model.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/error.h"
#include "mlic_core/sensors/double_sphere_model.h"
#include "mlic_core/sensors/equidistant_model.h"
#include "mlic_core/sensors/pinhole_model.h"

namespace mlic {
namespace {

const double* Parameters(const CameraIntrinsics& intrinsics) {
  Check(static_cast<int>(intrinsics.parameters.size()) == ParameterCount(intrinsics.model),
        "CameraIntrinsics: wrong number of parameters for the model");
  return intrinsics.parameters.data();
}

// alpha of a double sphere with xi = 0 whose radius at `half` is that of an equidistant projection of the
// same focal length, and whose domain reaches a third beyond `half`, for the corners.
double DoubleSphereAlpha(double half) {
  const double alpha = (std::sin(half) / half - std::cos(half)) / (1.0 - std::cos(half));
  const double reach = std::min(M_PI, half * 4.0 / 3.0);
  return std::min(alpha, 1.0 / (1.0 + std::max(0.0, -std::cos(reach))));
}

}  // namespace

int ParameterCount(CameraModel model) {
  switch (model) {
    case CameraModel::kPlumbBob:
      return 9;
    case CameraModel::kRationalPolynomial:
      return 12;
    case CameraModel::kEquidistant:
      return 8;
    case CameraModel::kDoubleSphere:
      return 6;
  }
  return 0;
}

std::vector<std::string> ParameterNames(CameraModel model) {
  switch (model) {
    case CameraModel::kPlumbBob:
      return {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
    case CameraModel::kRationalPolynomial:
      return {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
    case CameraModel::kEquidistant:
      return {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"};
    case CameraModel::kDoubleSphere:
      return {"fx", "fy", "cx", "cy", "xi", "alpha"};
  }
  return {};
}

bool Project(const CameraIntrinsics& intrinsics, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
             CameraPointJacobian* J_point, CameraParameterJacobian* J_parameters) {
  const double* parameters = Parameters(intrinsics);
  switch (intrinsics.model) {
    case CameraModel::kPlumbBob:
      return ProjectPinhole(parameters, false, point, pixel, J_point, J_parameters);
    case CameraModel::kRationalPolynomial:
      return ProjectPinhole(parameters, true, point, pixel, J_point, J_parameters);
    case CameraModel::kEquidistant:
      return ProjectEquidistant(parameters, point, pixel, J_point, J_parameters);
    case CameraModel::kDoubleSphere:
      return ProjectDoubleSphere(parameters, point, pixel, J_point, J_parameters);
  }
  return false;
}

bool Unproject(const CameraIntrinsics& intrinsics, const Eigen::Vector2d& pixel, Eigen::Vector3d* bearing) {
  const double* parameters = Parameters(intrinsics);
  switch (intrinsics.model) {
    case CameraModel::kPlumbBob:
      return UnprojectPinhole(parameters, false, pixel, bearing);
    case CameraModel::kRationalPolynomial:
      return UnprojectPinhole(parameters, true, pixel, bearing);
    case CameraModel::kEquidistant:
      return UnprojectEquidistant(parameters, pixel, bearing);
    case CameraModel::kDoubleSphere:
      return UnprojectDoubleSphere(parameters, pixel, bearing);
  }
  return false;
}

CameraIntrinsics IntrinsicsFromFieldOfView(CameraModel model, int width, int height, double fov_deg) {
  const bool pinhole = model == CameraModel::kPlumbBob || model == CameraModel::kRationalPolynomial;
  if (width <= 0 || height <= 0) {
    throw InputError("camera: image size " + std::to_string(width) + " x " + std::to_string(height) +
                     ": expected positive numbers of pixels");
  }
  if (!(fov_deg > 0.0) || (pinhole ? fov_deg >= 170.0 : fov_deg > 260.0)) {
    throw InputError(
        "camera: fov_deg " + std::to_string(fov_deg) + ": expected more than 0 and " +
        (pinhole ? "less than 170 for plumb_bob and rational_polynomial; use equidistant for wider lenses"
                 : "at most 260"));
  }
  CameraIntrinsics intrinsics;
  intrinsics.model = model;
  intrinsics.width = width;
  intrinsics.height = height;
  intrinsics.parameters.assign(ParameterCount(model), 0.0);
  const double half = 0.5 * fov_deg * M_PI / 180.0;
  double radius = half;  // of the image's left and right edge, in focal lengths
  if (pinhole) radius = std::tan(half);
  if (model == CameraModel::kDoubleSphere) {
    const double alpha = DoubleSphereAlpha(half);
    intrinsics.parameters[5] = alpha;
    radius = std::sin(half) / (alpha + (1.0 - alpha) * std::cos(half));
  }
  intrinsics.parameters[0] = intrinsics.parameters[1] = 0.5 * width / radius;
  intrinsics.parameters[2] = 0.5 * (width - 1);
  intrinsics.parameters[3] = 0.5 * (height - 1);
  return intrinsics;
}

}  // namespace mlic
