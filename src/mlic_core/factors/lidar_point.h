#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mlic_core/sensors/rig.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// Constants of this file, from: structural, places of columns.

// A point landmark P against its measurement x by a LiDAR, with Jacobians (docs/method.md, section 3.4):
//   r = A (R_imu_lidar^T (R(t)^T (P - p(t)) - p_imu_lidar) - x),   t = SensorCalibration::OnImuClock(t_point)
// with the rows of A across the beam (two) and along it, each divided by its sigma: whitened. Columns: 4
// rotation control points (right perturbations, 12), 4 position control points (12), extrinsic rotation (left
// perturbation, 3), extrinsic translation (3), time offset (1), the point P in the map frame (3). One
// residual's derivatives lie together in memory.
struct LidarPointResidual {
  static constexpr int kRotation = 0;
  static constexpr int kPosition = 12;
  static constexpr int kExtrinsic = 24;
  static constexpr int kTimeOffset = 30;
  static constexpr int kPoint = 31;
  static constexpr int kColumns = 34;
  using Jacobian = Eigen::Matrix<double, kColumns, 3>;  // column k: of residual k

  Eigen::Vector3d position;   // x, m, LiDAR frame; not at its origin
  double sigma_along = 1.0;   // m
  double sigma_across = 1.0;  // m

  // Bases at t. jacobian may be null.
  Eigen::Vector3d Evaluate(const SplitSpline& trajectory, const SplineBasis& rotation_basis,
                           const SplineBasis& position_basis, const SensorCalibration& lidar,
                           const Eigen::Vector3d& P, Jacobian* jacobian = nullptr) const {
    const Eigen::Vector3d from_imu = P - trajectory.position.Position(position_basis);
    So3Spline::Jacobians J;
    const So3Spline::Value rotation = trajectory.rotation.Evaluate(rotation_basis, false, &J);
    const Eigen::Vector3d y = rotation.rotation.transpose() * from_imu;
    const Eigen::Vector3d z = y - lidar.T_imu_sensor.translation;
    const Eigen::Matrix3d R_imu_lidar = lidar.T_imu_sensor.rotation.toRotationMatrix();
    const Eigen::Vector3d beam = position.normalized();
    Eigen::Matrix3d axes;
    axes.col(0) = beam.unitOrthogonal() / sigma_across;
    axes.col(1) = beam.cross(beam.unitOrthogonal()) / sigma_across;
    axes.col(2) = beam / sigma_along;
    const Eigen::Vector3d residual = axes.transpose() * (R_imu_lidar.transpose() * z - position);
    if (jacobian == nullptr) return residual;
    const Eigen::Vector3d y_dot =
        y.cross(rotation.angular_velocity) -
        rotation.rotation.transpose() * trajectory.position.Velocity(position_basis);
    const Eigen::Vector4d weights = SplineBasis::Weights(position_basis.lambda);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d by_y = R_imu_lidar * axes.col(k);
      const Eigen::Vector3d by_P = rotation.rotation * by_y;
      const Eigen::Vector3d by_rotation = by_y.cross(y);
      auto out = jacobian->col(k);
      for (int j = 0; j < 4; ++j) {
        out.segment<3>(kRotation + 3 * j) = J.rotation[j].transpose() * by_rotation;
        out.segment<3>(kPosition + 3 * j) = -weights[j] * by_P;
      }
      out.segment<3>(kExtrinsic) = by_y.cross(z);
      out.segment<3>(kExtrinsic + 3) = -by_y;
      out[kTimeOffset] = by_y.dot(y_dot);
      out.segment<3>(kPoint) = by_P;
    }
    return residual;
  }
};

}  // namespace mlic
