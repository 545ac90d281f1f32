#include "mlic_core/sensors/double_sphere_model.h"

#include <cmath>

namespace mlic {

bool ProjectDoubleSphere(const double* parameters, const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                         CameraPointJacobian* J_point, CameraParameterJacobian* J_parameters) {
  const double fx = parameters[0], fy = parameters[1], xi = parameters[4], alpha = parameters[5];
  const double x = point.x(), y = point.y(), z = point.z();
  const double rr = x * x + y * y;
  const double d1 = std::sqrt(rr + z * z);
  const double w1 = alpha > 0.5 ? (1.0 - alpha) / alpha : alpha / (1.0 - alpha);
  const double w2 = (w1 + xi) / std::sqrt(2.0 * w1 * xi + xi * xi + 1.0);
  if (!(z > -w2 * d1)) return false;
  const double z1 = xi * d1 + z;
  const double d2 = std::sqrt(rr + z1 * z1);
  const double below = alpha * d2 + (1.0 - alpha) * z1;
  if (!(below > 0.0)) return false;
  const double inverse = 1.0 / below;
  const double mx = x * inverse, my = y * inverse;
  *pixel << fx * mx + parameters[2], fy * my + parameters[3];
  if (J_point == nullptr && J_parameters == nullptr) return true;
  const double by_z1 = alpha * z1 / d2 + 1.0 - alpha;  // of `below` to z1
  if (J_point != nullptr) {
    const double across = alpha / d2 + by_z1 * xi / d1;  // of `below` to x, y: times x, y
    const double along = by_z1 * (xi * z / d1 + 1.0);    // of `below` to z
    *J_point << fx * inverse * (1.0 - mx * across * x), -fx * inverse * mx * across * y,
        -fx * inverse * mx * along, -fy * inverse * my * across * x, fy * inverse * (1.0 - my * across * y),
        -fy * inverse * my * along;
  }
  if (J_parameters != nullptr) {
    CameraParameterJacobian& J = *J_parameters;
    J.resize(2, 6);
    J.col(0) << mx, 0.0;
    J.col(1) << 0.0, my;
    J.col(2) << 1.0, 0.0;
    J.col(3) << 0.0, 1.0;
    const Eigen::Vector2d by_below(-fx * mx * inverse, -fy * my * inverse);
    J.col(4) = by_below * (by_z1 * d1);
    J.col(5) = by_below * (d2 - z1);
  }
  return true;
}

bool UnprojectDoubleSphere(const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d* bearing) {
  const double xi = parameters[4], alpha = parameters[5];
  const double mx = (pixel.x() - parameters[2]) / parameters[0],
               my = (pixel.y() - parameters[3]) / parameters[1];
  const double rr = mx * mx + my * my;
  const double under_root = 1.0 - (2.0 * alpha - 1.0) * rr;
  if (!(under_root >= 0.0)) return false;
  const double mz = (1.0 - alpha * alpha * rr) / (alpha * std::sqrt(under_root) + 1.0 - alpha);
  const double under_second = mz * mz + (1.0 - xi * xi) * rr;
  if (!(under_second >= 0.0)) return false;
  const double scale = (mz * xi + std::sqrt(under_second)) / (mz * mz + rr);
  const Eigen::Vector3d candidate = Eigen::Vector3d(scale * mx, scale * my, scale * mz - xi).normalized();
  // The closed form also answers where the projection is not defined; there it does not come back.
  Eigen::Vector2d back;
  if (!ProjectDoubleSphere(parameters, candidate, &back, nullptr, nullptr)) return false;
  if (!((back - pixel).norm() < 1e-6 * (1.0 + std::abs(parameters[0])))) return false;
  *bearing = candidate;
  return true;
}

}  // namespace mlic
