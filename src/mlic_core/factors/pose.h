#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// Constants of this file, from: structural, places of columns.

// The trajectory against a given pose at a time t, whitened:
//   r = (Log(R_given^T R(t)) / sigma_rotation, (p(t) - p_given) / sigma_translation)
// Columns: 4 rotation control points (right perturbations, 12), 4 position control points (12).
struct PoseResidual {
  static constexpr int kPosition = 12;
  static constexpr int kColumns = 24;
  using Jacobian = Eigen::Matrix<double, kColumns, 6>;  // column k: of residual k

  RigidTransform T_map_imu;        // as given
  double sigma_rotation = 1.0;     // rad
  double sigma_translation = 1.0;  // m

  // Bases at t. jacobian may be null.
  Eigen::Matrix<double, 6, 1> Evaluate(const SplitSpline& trajectory, const SplineBasis& rotation_basis,
                                       const SplineBasis& position_basis,
                                       Jacobian* jacobian = nullptr) const {
    So3Spline::Jacobians J;
    const So3Spline::Value value = jacobian != nullptr
                                       ? trajectory.rotation.Evaluate(rotation_basis, false, &J)
                                       : trajectory.rotation.Evaluate(rotation_basis);
    Eigen::Matrix<double, 6, 1> residual;
    residual.head<3>() =
        Log(T_map_imu.rotation.conjugate() * Eigen::Quaterniond(value.rotation)) / sigma_rotation;
    residual.tail<3>() =
        (trajectory.position.Position(position_basis) - T_map_imu.translation) / sigma_translation;
    if (jacobian == nullptr) return residual;
    const Eigen::Matrix3d inverse = RightJacobianInverse(residual.head<3>() * sigma_rotation);
    const Eigen::Vector4d weights = SplineBasis::Weights(position_basis.lambda);
    jacobian->setZero();
    for (int j = 0; j < 4; ++j) {
      jacobian->block<3, 3>(3 * j, 0) = (inverse * J.rotation[j]).transpose() / sigma_rotation;
      jacobian->block<3, 3>(kPosition + 3 * j, 3) =
          (weights[j] / sigma_translation) * Eigen::Matrix3d::Identity();
    }
    return residual;
  }
};

}  // namespace mlic
