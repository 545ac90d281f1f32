#include "mlic_core/sensors/equidistant_model.h"

#include <cmath>

#include "mlic_core/sensors/positive_polynomial.h"

namespace mlic {
namespace {

double Radius(const double* k, double theta) {
  const double q = theta * theta;
  return theta * (1.0 + q * (k[0] + q * (k[1] + q * (k[2] + q * k[3]))));
}

double RadiusSlope(const double* k, double theta) {
  const double q = theta * theta;
  return 1.0 + q * (3.0 * k[0] + q * (5.0 * k[1] + q * (7.0 * k[2] + q * 9.0 * k[3])));
}

bool Monotonic(const double* k, double theta) {
  const double slope[5] = {1.0, 3.0 * k[0], 5.0 * k[1], 7.0 * k[2], 9.0 * k[3]};
  return PositivePolynomial<4>::On(slope, theta * theta);
}

// Newton's method kept within the bracket by bisection. False where no angle up to pi has this radius.
bool AngleOfRadius(const double* k, double radius, double* theta) {
  double low = 0.0, high = M_PI;
  double value = radius < M_PI ? radius : 0.5 * M_PI;
  for (int iteration = 0; iteration < 80; ++iteration) {
    const bool monotonic = Monotonic(k, value);
    const double error = Radius(k, value) - radius;
    if (monotonic && std::abs(error) < 1e-15 * (1.0 + radius)) break;
    (monotonic && error < 0.0 ? low : high) = value;
    const double next = monotonic ? value - error / RadiusSlope(k, value) : low;
    const double before = value;
    value = next > low && next < high ? next : 0.5 * (low + high);
    if (std::abs(value - before) < 1e-16 * M_PI) break;
  }
  *theta = Monotonic(k, value) ? value : low;
  return *theta < M_PI && std::abs(Radius(k, *theta) - radius) < 1e-10 * (1.0 + radius);
}

}  // namespace

bool ProjectEquidistant(const double* parameters, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                        CameraPointJacobian* J_point, CameraParameterJacobian* J_parameters) {
  const double x = point.x(), y = point.y(), z = point.z();
  const double r = std::sqrt(x * x + y * y);
  if (r == 0.0 && !(z > 0.0)) return false;  // the way to the side is undefined
  const double theta = std::atan2(r, z);
  const double* k = parameters + 4;
  if (!Monotonic(k, theta)) return false;
  const double fx = parameters[0], fy = parameters[1];
  const double nx = r > 0.0 ? x / r : 0.0, ny = r > 0.0 ? y / r : 0.0;
  const double radius = Radius(k, theta);
  *pixel << fx * radius * nx + parameters[2], fy * radius * ny + parameters[3];
  if (J_point != nullptr) {
    const double slope = RadiusSlope(k, theta) / (r * r + z * z);
    const double across = r > 0.0 ? radius / r : 1.0 / z;  // per metre, at right angles to the radius
    const double along = slope * z - across;
    *J_point << fx * (across + along * nx * nx), fx * along * nx * ny, -fx * slope * x, fy * along * nx * ny,
        fy * (across + along * ny * ny), -fy * slope * y;
  }
  if (J_parameters != nullptr) {
    CameraParameterJacobian& J = *J_parameters;
    J.resize(2, 8);
    J.col(0) << radius * nx, 0.0;
    J.col(1) << 0.0, radius * ny;
    J.col(2) << 1.0, 0.0;
    J.col(3) << 0.0, 1.0;
    const double q = theta * theta;
    double power = theta;
    for (int i = 0; i < 4; ++i) {
      power *= q;
      J.col(4 + i) << fx * nx * power, fy * ny * power;
    }
  }
  return true;
}

bool UnprojectEquidistant(const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d* bearing) {
  const double x = (pixel.x() - parameters[2]) / parameters[0],
               y = (pixel.y() - parameters[3]) / parameters[1];
  const double radius = std::sqrt(x * x + y * y);
  double theta;
  if (!std::isfinite(radius) || !AngleOfRadius(parameters + 4, radius, &theta)) return false;
  const double scale = radius > 0.0 ? std::sin(theta) / radius : 0.0;
  *bearing << x * scale, y * scale, std::cos(theta);
  return true;
}

}  // namespace mlic
