#pragma once

#include <ceres/autodiff_cost_function.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>

#include "mlic_core/trajectory/spline_basis.h"

namespace mlic {

// The residuals of factors/ written once more as plain templates for Ceres' automatic differentiation, as
// most continuous-time calibration codes do; the reference for speed and for values.

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

template <typename T>
Eigen::Quaternion<T> ExpOf(const Vector3<T>& v) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T squared = v.squaredNorm();
  if (squared < T(1e-16))
    return Eigen::Quaternion<T>(T(1), v.x() / T(2), v.y() / T(2), v.z() / T(2)).normalized();
  const T angle = sqrt(squared);
  const T scale = sin(angle / T(2)) / angle;
  return Eigen::Quaternion<T>(cos(angle / T(2)), scale * v.x(), scale * v.y(), scale * v.z());
}

template <typename T>
Vector3<T> LogOf(const Eigen::Quaternion<T>& q) {
  using std::atan2;
  using std::sqrt;
  const T squared = q.vec().squaredNorm();
  if (squared < T(1e-16)) return T(2) * q.vec();
  const T sine = sqrt(squared);
  return (T(2) * atan2(sine, q.w()) / sine) * q.vec();
}

// Rotation and body angular velocity at the cumulative coefficients lambda, lambda_dot.
template <typename T>
void EvaluateRotation(const T* const* knots, const Eigen::Matrix<T, 4, 1>& lambda,
                      const Eigen::Matrix<T, 4, 1>& lambda_dot, Eigen::Quaternion<T>* rotation,
                      Vector3<T>* velocity) {
  *rotation = Eigen::Map<const Eigen::Quaternion<T>>(knots[0]);
  velocity->setZero();
  for (int j = 1; j < 4; ++j) {
    const Eigen::Quaternion<T> before = Eigen::Map<const Eigen::Quaternion<T>>(knots[j - 1]);
    const Vector3<T> d = LogOf<T>(before.conjugate() * Eigen::Map<const Eigen::Quaternion<T>>(knots[j]));
    const Eigen::Quaternion<T> step = ExpOf<T>(lambda[j] * d);
    *rotation = *rotation * step;
    *velocity = step.conjugate() * *velocity + lambda_dot[j] * d;
  }
}

template <typename T>
Vector3<T> EvaluatePosition(const T* const* knots, const Eigen::Matrix<T, 4, 1>& cumulative) {
  Vector3<T> sum = cumulative[0] * Eigen::Map<const Vector3<T>>(knots[0]);
  for (int j = 1; j < 4; ++j)
    sum +=
        cumulative[j] * (Eigen::Map<const Vector3<T>>(knots[j]) - Eigen::Map<const Vector3<T>>(knots[j - 1]));
  return sum;
}

// Parameter blocks: 4 rotations (4), 4 positions (3), gyroscope bias (3), accelerometer bias (3).
struct ImuAutodiff {
  SplineBasis rotation_basis, position_basis;
  Eigen::Vector3d angular_velocity, specific_force, gravity;

  template <typename T>
  bool operator()(const T* r0, const T* r1, const T* r2, const T* r3, const T* p0, const T* p1, const T* p2,
                  const T* p3, const T* gyroscope_bias, const T* accelerometer_bias, T* residual) const {
    const T* rotations[4] = {r0, r1, r2, r3};
    const T* positions[4] = {p0, p1, p2, p3};
    Eigen::Quaternion<T> rotation;
    Vector3<T> velocity;
    EvaluateRotation<T>(rotations, rotation_basis.lambda.cast<T>(), rotation_basis.lambda_dot.cast<T>(),
                        &rotation, &velocity);
    const Vector3<T> acceleration = EvaluatePosition<T>(positions, position_basis.lambda_ddot.cast<T>());
    const Vector3<T> force = rotation.conjugate() * Vector3<T>(acceleration - gravity.cast<T>());
    Eigen::Map<Vector3<T>> r_w(residual), r_a(residual + 3);
    r_w = velocity + Eigen::Map<const Vector3<T>>(gyroscope_bias) - angular_velocity.cast<T>();
    r_a = force + Eigen::Map<const Vector3<T>>(accelerometer_bias) - specific_force.cast<T>();
    return true;
  }

  static ceres::CostFunction* Create(const ImuAutodiff& residual) {
    return new ceres::AutoDiffCostFunction<ImuAutodiff, 6, 4, 4, 4, 4, 3, 3, 3, 3, 3, 3>(
        new ImuAutodiff(residual));
  }
};

// Parameter blocks: 4 rotations (4), 4 positions (3), and one of extrinsic rotation (4), extrinsic
// translation (3), time offset (1), tilts of the plane (2) and its offset (1).
struct PointToPlaneAutodiff {
  double u_rotation, u_position;  // normalised times in the segments at time offset 0
  double rotation_spacing, position_spacing;
  Eigen::Vector3d x, normal, tangent_u, tangent_v, anchor;

  template <typename T>
  static void Basis(const T& u, double spacing, Eigen::Matrix<T, 4, 1>* lambda,
                    Eigen::Matrix<T, 4, 1>* lambda_dot) {
    const T uu = u * u, uuu = uu * u;
    *lambda << T(1), (T(5) + T(3) * u - T(3) * uu + uuu) / T(6),
        (T(1) + T(3) * u + T(3) * uu - T(2) * uuu) / T(6), uuu / T(6);
    *lambda_dot << T(0), (T(3) - T(6) * u + T(3) * uu) / T(6), (T(3) + T(6) * u - T(6) * uu) / T(6),
        uu / T(2);
    *lambda_dot /= T(spacing);
  }

  template <typename T>
  bool operator()(const T* r0, const T* r1, const T* r2, const T* r3, const T* p0, const T* p1, const T* p2,
                  const T* p3, const T* other, T* residual) const {
    const T* rotations[4] = {r0, r1, r2, r3};
    const T* positions[4] = {p0, p1, p2, p3};
    const Eigen::Quaternion<T> R_imu_lidar = Eigen::Map<const Eigen::Quaternion<T>>(other);
    const T& time_offset = other[7];
    Eigen::Matrix<T, 4, 1> lambda, lambda_dot;
    Basis<T>(T(u_rotation) + time_offset / T(rotation_spacing), rotation_spacing, &lambda, &lambda_dot);
    Eigen::Quaternion<T> rotation;
    Vector3<T> velocity;
    EvaluateRotation<T>(rotations, lambda, lambda_dot, &rotation, &velocity);
    Basis<T>(T(u_position) + time_offset / T(position_spacing), position_spacing, &lambda, &lambda_dot);
    const Vector3<T> beam = R_imu_lidar * Vector3<T>(x.cast<T>());
    const Vector3<T> y = beam + Eigen::Map<const Vector3<T>>(other + 4);
    const Vector3<T> in_map = rotation * y + EvaluatePosition<T>(positions, lambda);
    const Vector3<T> n = normal.cast<T>() + other[8] * tangent_u.cast<T>() + other[9] * tangent_v.cast<T>();
    *residual = (other[10] - n.dot(in_map - anchor.cast<T>())) * T(x.norm()) / n.dot(rotation * beam);
    return true;
  }

  static ceres::CostFunction* Create(const PointToPlaneAutodiff& residual) {
    return new ceres::AutoDiffCostFunction<PointToPlaneAutodiff, 1, 4, 4, 4, 4, 3, 3, 3, 3, 11>(
        new PointToPlaneAutodiff(residual));
  }
};

}  // namespace mlic
