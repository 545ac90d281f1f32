#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/trajectory/so3_spline.h"

namespace mlic {

// Uniform cubic B-spline on R^3.
class PositionSpline {
 public:
  PositionSpline() = default;
  PositionSpline(const UniformKnots& knots, std::vector<Eigen::Vector3d> control_points);

  const UniformKnots& knots() const { return knots_; }
  const std::vector<Eigen::Vector3d>& control_points() const { return control_points_; }

  Eigen::Vector3d Position(const SplineBasis& basis) const { return Combine(basis.first, basis.lambda); }
  Eigen::Vector3d Velocity(const SplineBasis& basis) const { return Combine(basis.first, basis.lambda_dot); }
  Eigen::Vector3d Acceleration(const SplineBasis& basis) const {
    return Combine(basis.first, basis.lambda_ddot);
  }

  // control_points[j] += delta.segment<3>(offsets[j]).
  void Update(const Eigen::VectorXd& delta, const std::vector<int>& offsets);

 private:
  Eigen::Vector3d Combine(int first, const Eigen::Vector4d& cumulative) const {
    const Eigen::Vector4d w = SplineBasis::Weights(cumulative);
    const Eigen::Vector3d* p = &control_points_[first];
    return w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + w[3] * p[3];
  }

  UniformKnots knots_;
  std::vector<Eigen::Vector3d> control_points_;
};

// The trajectory T_map_imu(t): a rotation spline and a position spline with knots of their own. Times are
// seconds since the drive's epoch on the IMU clock.
struct SplitSpline {
  So3Spline rotation;
  PositionSpline position;

  // Where both are defined.
  double Start() const;
  double End() const;
  double Middle() const { return 0.5 * (Start() + End()); }
  bool Contains(double time) const { return time >= Start() && time <= End(); }

  RigidTransform Pose(double time) const;
};

}  // namespace mlic
