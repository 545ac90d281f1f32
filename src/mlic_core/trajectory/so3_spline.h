#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "mlic_core/trajectory/spline_basis.h"

namespace mlic {

// Cumulative cubic B-spline on SO(3):
//   R(t) = R_i * Exp(lambda_1 d_1) * Exp(lambda_2 d_2) * Exp(lambda_3 d_3),  d_j = Log(R_{i+j-1}^-1 *
//   R_{i+j}).
// Perturbations are on the right: control points R_j * Exp(delta_j), value R * Exp(rho). Derivatives by the
// O(order) recursions of Sommer et al. (CVPR 2020), restated for right perturbations. What depends on pairs
// of neighbouring control points only is computed once after each change and shared by all evaluations in
// between. docs/method.md, section 2.
class So3Spline {
 public:
  So3Spline() = default;
  So3Spline(const UniformKnots& knots, std::vector<Eigen::Quaterniond> control_points);

  struct Value {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d angular_velocity;  // body frame, rad/s
  };

  // Jacobians to the right perturbations of control points first .. first+3.
  struct Jacobians {
    Eigen::Matrix3d rotation[4];          // of rho
    Eigen::Matrix3d angular_velocity[4];  // of the body angular velocity
  };

  const UniformKnots& knots() const { return knots_; }
  const std::vector<Eigen::Quaterniond>& control_points() const { return control_points_; }

  Eigen::Quaterniond Rotation(double time) const;
  Eigen::Vector3d AngularVelocity(double time) const;
  // Body frame, rad/s^2.
  Eigen::Vector3d AngularAcceleration(double time) const;

  Value Evaluate(const SplineBasis& basis) const;
  // Fills rotation Jacobians; those of the angular velocity only if with_velocity.
  Value Evaluate(const SplineBasis& basis, bool with_velocity, Jacobians* jacobians) const;

  // control_points[j] *= Exp(delta.segment<3>(offset_of(j))) for all j; offsets are indices into delta.
  void Update(const Eigen::VectorXd& delta, const std::vector<int>& offsets);

 private:
  void UpdateDifferences();

  UniformKnots knots_;
  std::vector<Eigen::Quaterniond> control_points_;
  std::vector<Eigen::Matrix3d> rotations_;                // of the control points
  std::vector<Eigen::Vector3d> differences_;              // Log(R_j^-1 * R_{j+1})
  std::vector<Eigen::Matrix3d> right_jacobian_inverses_;  // of the differences
};

}  // namespace mlic
