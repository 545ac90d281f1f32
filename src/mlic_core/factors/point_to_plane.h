#pragma once

#include <Eigen/Core>

#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// The LiDAR plane residual (SPEC section 3), with its Jacobians in one pass:
//   r = n . (R(t) (R_imu_lidar x + p_imu_lidar) + p(t) - c) - d,   t = t_point + time_offset
// c: the plane's anchor, a point well within its patch, about which its 3 parameters are taken; so no plane
// is singular. Row layout: 4 rotation control points (right perturbations, 12), 4 position control points
// (12), extrinsic rotation (left perturbation, 3), extrinsic translation (3), time offset (1), plane (tilt
// about the two tangents and offset d, 3).
struct PointToPlane {
  static constexpr int kRotation = 0;
  static constexpr int kPosition = 12;
  static constexpr int kExtrinsic = 24;
  static constexpr int kTimeOffset = 30;
  static constexpr int kPlane = 31;
  static constexpr int kColumns = 34;

  Eigen::Vector3d normal, anchor, tangent_u, tangent_v;  // unit vectors; map frame
  double offset = 0.0;                                   // d, m

  struct Extrinsic {
    Eigen::Matrix3d R_imu_lidar;
    Eigen::Vector3d p_imu_lidar;
  };

  // x: the point in the LiDAR frame; bases at t. Returns r in metres; writes the row if not null.
  double Evaluate(const SplitSpline& trajectory, const SplineBasis& rotation_basis,
                  const SplineBasis& position_basis, const Extrinsic& extrinsic, const Eigen::Vector3d& x,
                  double* row) const {
    const Eigen::Vector3d q = extrinsic.R_imu_lidar * x;
    const Eigen::Vector3d y = q + extrinsic.p_imu_lidar;
    const Eigen::Vector3d position = trajectory.position.Position(position_basis);
    So3Spline::Jacobians J;
    const So3Spline::Value rotation = row != nullptr ? trajectory.rotation.Evaluate(rotation_basis, false, &J)
                                                     : trajectory.rotation.Evaluate(rotation_basis);
    const Eigen::Vector3d from_anchor = rotation.rotation * y + position - anchor;
    const double residual = normal.dot(from_anchor) - offset;
    if (row == nullptr) return residual;
    const Eigen::Vector3d m = rotation.rotation.transpose() * normal;  // the normal in the IMU frame
    const Eigen::Vector3d to_rotation = y.cross(m);
    const Eigen::Vector4d weights = SplineBasis::Weights(position_basis.lambda);
    Eigen::Map<Eigen::Matrix<double, kColumns, 1>> out(row);
    for (int j = 0; j < 4; ++j) {
      out.segment<3>(kRotation + 3 * j).noalias() = J.rotation[j].transpose() * to_rotation;
      out.segment<3>(kPosition + 3 * j) = weights[j] * normal;
    }
    out.segment<3>(kExtrinsic) = q.cross(m);
    out.segment<3>(kExtrinsic + 3) = m;
    out[kTimeOffset] =
        m.dot(rotation.angular_velocity.cross(y)) + normal.dot(trajectory.position.Velocity(position_basis));
    out[kPlane] = tangent_u.dot(from_anchor);
    out[kPlane + 1] = tangent_v.dot(from_anchor);
    out[kPlane + 2] = -1.0;
    return residual;
  }
};

}  // namespace mlic
