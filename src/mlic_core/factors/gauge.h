#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// Constants of this file, from: structural, places of columns.

// The map's position and yaw are free: no measurement says where its origin is. They are fixed where they
// are, at a time t, by
//   r = kScale (p(t) - p_fixed, e_z . Log(R(t) R_imu_sensor R_fixed^T))
// whitened by a sigma of 1 / kScale (m, rad), so small that it holds and so large that it does not spoil the
// conditioning. It is the yaw of a sensor that sees the map: where the IMU is found to be turned against that
// sensor, trajectory and map stay as they are, and a large step is as good as a small one. Columns: 4
// rotation control points (right perturbations, 12), 4 position control points (12), the rotation of the
// sensor (left perturbation, 3).
struct GaugeResidual {
  static constexpr int kPosition = 12;
  static constexpr int kSensor = 24;
  static constexpr int kColumns = 27;
  static constexpr double kScale = 1e4;  // from: guard, 0.1 mm and 6e-3 deg: far below any sigma of the map
  using Jacobian = Eigen::Matrix<double, kColumns, 4>;  // column k: of residual k

  Eigen::Matrix3d R_fixed;
  Eigen::Vector3d p_fixed;  // m
  Eigen::Matrix3d R_imu_sensor = Eigen::Matrix3d::Identity();

  // Bases at t.
  Eigen::Vector4d Evaluate(const SplitSpline& trajectory, const SplineBasis& rotation_basis,
                           const SplineBasis& position_basis) const {
    const Eigen::Matrix3d R = trajectory.rotation.Evaluate(rotation_basis).rotation;
    Eigen::Vector4d residual;
    residual.head<3>() = trajectory.position.Position(position_basis) - p_fixed;
    residual[3] = Log(Eigen::Quaterniond(R * R_imu_sensor * R_fixed.transpose())).z();
    return kScale * residual;
  }

  // Of the residual where it is zero: the pose is the fixed one.
  static Jacobian JacobianAtZero(const SplitSpline& trajectory, const SplineBasis& rotation_basis,
                                 const SplineBasis& position_basis) {
    So3Spline::Jacobians J;
    const So3Spline::Value value = trajectory.rotation.Evaluate(rotation_basis, false, &J);
    const Eigen::Vector4d weights = SplineBasis::Weights(position_basis.lambda);
    Jacobian jacobian = Jacobian::Zero();
    for (int j = 0; j < 4; ++j) {
      jacobian.block<3, 3>(kPosition + 3 * j, 0) = weights[j] * kScale * Eigen::Matrix3d::Identity();
      jacobian.block<3, 1>(3 * j, 3) = kScale * (value.rotation * J.rotation[j]).row(2).transpose();
    }
    jacobian.block<3, 1>(kSensor, 3) = kScale * value.rotation.row(2).transpose();
    return jacobian;
  }
};

}  // namespace mlic
