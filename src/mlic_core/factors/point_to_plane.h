#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// The LiDAR plane residual (docs/method.md, section 3.2), taken along the beam, with Jacobians in one pass:
//   r = (n . (R(t) (R_imu_lidar x + p_imu_lidar) + p(t) - c) - d) / cos,
//   t = SensorCalibration::OnImuClock(t_point),
// in metres, not whitened. cos: of the incidence, so r is by how much the measured range falls short of the
// plane. Along the plane's normal the noise of the range would stand in the Jacobians too, and E[noise *
// Jacobian] != 0 tilts planes and LiDARs (errors in variables: 0.01 deg at 2 cm of noise); the range that is
// predicted hangs on the beam's direction alone. So the Jacobians are those at the point where the beam meets
// the plane. c: the plane's anchor, a point well within its patch, about which its 3 parameters are taken; so
// no plane is singular. Row layout: 4 rotation control points (right perturbations, 12), 4 position control
// points (12), extrinsic rotation (left perturbation, 3), extrinsic translation (3), time offset (1), plane
// (tilt about the two tangents and offset d, 3).
struct PointToPlane {
  static constexpr int kRotation = 0;          // from: structural, places of columns
  static constexpr int kPosition = 12;         // from: structural, places of columns
  static constexpr int kExtrinsic = 24;        // from: structural, places of columns
  static constexpr int kTimeOffset = 30;       // from: structural, places of columns
  static constexpr int kPlane = 31;            // from: structural, places of columns
  static constexpr int kColumns = 34;          // from: structural, places of columns
  static constexpr double kLeastCosine = 0.1;  // planes are seen from their front, never edge on; from: guard

  Eigen::Vector3d normal, anchor, tangent_u, tangent_v;  // unit vectors; map frame
  double offset = 0.0;                                   // d, m

  struct Extrinsic {
    Eigen::Matrix3d R_imu_lidar;
    Eigen::Vector3d p_imu_lidar;
  };

  // x: the point in the LiDAR frame; bases at t. Returns r in metres (along the beam); writes the row if not
  // null.
  double Evaluate(const SplitSpline& trajectory, const SplineBasis& rotation_basis,
                  const SplineBasis& position_basis, const Extrinsic& extrinsic, const Eigen::Vector3d& x,
                  double* row) const {
    Eigen::Vector3d q = extrinsic.R_imu_lidar * x;
    const Eigen::Vector3d position = trajectory.position.Position(position_basis);
    So3Spline::Jacobians J;
    const So3Spline::Value rotation = row != nullptr ? trajectory.rotation.Evaluate(rotation_basis, false, &J)
                                                     : trajectory.rotation.Evaluate(rotation_basis);
    const Eigen::Vector3d m = rotation.rotation.transpose() * normal;  // the normal in the IMU frame
    const double from_plane = m.dot(q + extrinsic.p_imu_lidar) + normal.dot(position - anchor) - offset;
    const double facing = -m.dot(q);
    const double to_beam = q.norm() / std::max(facing, kLeastCosine * q.norm());
    const double residual = to_beam * from_plane;
    if (row == nullptr) return residual;
    q *= 1.0 + residual / q.norm();  // where the beam meets the plane
    const Eigen::Vector3d y = q + extrinsic.p_imu_lidar;
    const Eigen::Vector3d from_anchor = rotation.rotation * y + position - anchor;
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
    out *= to_beam;
    return residual;
  }
};

}  // namespace mlic
