#include "mlic_core/trajectory/so3_spline.h"

#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

// Exp(v) and the right Jacobian at v share their sines; v is the scaled difference of neighbouring control
// points.
inline void ExpWithRightJacobian(const Eigen::Vector3d& v, Eigen::Matrix3d* exp, Eigen::Matrix3d* jacobian) {
  const double squared = v.squaredNorm();
  double a, b, c;
  if (squared < 1e-2) {
    // Series to 1e-17 relative at this size; neighbouring control points are close, so this is the usual
    // branch.
    a = 1.0 +
        squared * (-1.0 / 6 + squared * (1.0 / 120 + squared * (-1.0 / 5040 + squared * (1.0 / 362880))));
    b = 0.5 + squared * (-1.0 / 24 + squared * (1.0 / 720 + squared * (-1.0 / 40320 + squared / 3628800)));
    c = 1.0 / 6 +
        squared * (-1.0 / 120 + squared * (1.0 / 5040 + squared * (-1.0 / 362880 + squared / 39916800)));
  } else {
    const double angle = std::sqrt(squared);
    const double half = std::sin(0.5 * angle);
    const double sine = std::sin(angle);
    a = sine / angle;
    b = 2.0 * half * half / squared;
    c = (angle - sine) / (squared * angle);
  }
  const double x = v.x(), y = v.y(), z = v.z();
  const double xx = x * x - squared, yy = y * y - squared, zz = z * z - squared;
  const double xy = x * y, xz = x * z, yz = y * z;
  *exp << 1.0 + b * xx, b * xy - a * z, b * xz + a * y, b * xy + a * z, 1.0 + b * yy, b * yz - a * x,
      b * xz - a * y, b * yz + a * x, 1.0 + b * zz;
  if (jacobian != nullptr) {
    *jacobian << 1.0 + c * xx, c * xy + b * z, c * xz - b * y, c * xy - b * z, 1.0 + c * yy, c * yz + b * x,
        c * xz + b * y, c * yz - b * x, 1.0 + c * zz;
  }
}

}  // namespace

So3Spline::So3Spline(const UniformKnots& knots, std::vector<Eigen::Quaterniond> control_points)
    : knots_(knots), control_points_(std::move(control_points)) {
  Check(static_cast<int>(control_points_.size()) == knots_.count,
        "So3Spline: wrong number of control points");
  UpdateDifferences();
}

void So3Spline::UpdateDifferences() {
  const std::size_t count = control_points_.size();
  rotations_.resize(count);
  differences_.resize(count - 1);
  right_jacobian_inverses_.resize(count - 1);
  for (std::size_t j = 0; j < count; ++j) rotations_[j] = control_points_[j].toRotationMatrix();
  for (std::size_t j = 0; j + 1 < count; ++j) {
    differences_[j] = Log(control_points_[j].conjugate() * control_points_[j + 1]);
    right_jacobian_inverses_[j] = RightJacobianInverse(differences_[j]);
  }
}

void So3Spline::Update(const Eigen::VectorXd& delta, const std::vector<int>& offsets) {
  for (std::size_t j = 0; j < control_points_.size(); ++j) {
    control_points_[j] = (control_points_[j] * ExpQuaternion(delta.segment<3>(offsets[j]))).normalized();
  }
  UpdateDifferences();
}

Eigen::Quaterniond So3Spline::Rotation(double time) const {
  const SplineBasis basis(knots_, time);
  Eigen::Quaterniond q = control_points_[basis.first];
  for (int j = 1; j < 4; ++j) q = q * ExpQuaternion(basis.lambda[j] * differences_[basis.first + j - 1]);
  return q.normalized();
}

So3Spline::Value So3Spline::Evaluate(const SplineBasis& basis) const {
  Eigen::Matrix3d rotation = rotations_[basis.first];
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  for (int j = 1; j < 4; ++j) {
    const Eigen::Vector3d& d = differences_[basis.first + j - 1];
    Eigen::Matrix3d A;
    ExpWithRightJacobian(basis.lambda[j] * d, &A, nullptr);
    rotation = (rotation * A).eval();
    velocity = (A.transpose() * velocity + basis.lambda_dot[j] * d).eval();
  }
  return {rotation, velocity};
}

Eigen::Vector3d So3Spline::AngularVelocity(double time) const {
  return Evaluate(SplineBasis(knots_, time)).angular_velocity;
}

Eigen::Vector3d So3Spline::AngularAcceleration(double time) const {
  const SplineBasis basis(knots_, time);
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  for (int j = 1; j < 4; ++j) {
    const Eigen::Vector3d& d = differences_[basis.first + j - 1];
    const Eigen::Matrix3d A_transposed = ExpMatrix(-basis.lambda[j] * d);
    const Eigen::Vector3d turned = A_transposed * velocity;
    acceleration =
        (A_transposed * acceleration + basis.lambda_dot[j] * turned.cross(d) + basis.lambda_ddot[j] * d)
            .eval();
    velocity = turned + basis.lambda_dot[j] * d;
  }
  return acceleration;
}

So3Spline::Value So3Spline::Evaluate(const SplineBasis& basis, bool with_velocity,
                                     Jacobians* jacobians) const {
  const int first = basis.first;
  Eigen::Matrix3d A[4], M[4];
  for (int j = 1; j < 4; ++j) {
    Eigen::Matrix3d right_jacobian;
    ExpWithRightJacobian(basis.lambda[j] * differences_[first + j - 1], &A[j], &right_jacobian);
    M[j].noalias() = basis.lambda[j] * right_jacobian;  // of rho_j to d_j, where A_j becomes A_j * Exp(rho_j)
  }
  Value value;
  const Eigen::Vector3d omega_1 = basis.lambda_dot[1] * differences_[first];
  const Eigen::Vector3d turned_2 = A[2].transpose() * omega_1;
  const Eigen::Vector3d omega_2 = turned_2 + basis.lambda_dot[2] * differences_[first + 1];
  const Eigen::Vector3d turned_3 = A[3].transpose() * omega_2;
  value.angular_velocity = turned_3 + basis.lambda_dot[3] * differences_[first + 2];

  const Eigen::Matrix3d P1 = A[2] * A[3];  // the factors right of A_1
  const Eigen::Matrix3d A1P1 = A[1] * P1;
  value.rotation.noalias() = rotations_[first] * A1P1;

  // To the differences d_1 .. d_3, carried through the factors right of them.
  Eigen::Matrix3d D[4];
  D[1].noalias() = P1.transpose() * M[1];
  D[2].noalias() = A[3].transpose() * M[2];
  D[3] = M[3];
  // To the control points: d_j grows by Jr^-1(d_j) delta_j and shrinks by Jl^-1(d_j) delta_{j-1}; Jl^-1 =
  // Jr^-T.
  const Eigen::Matrix3d* inverse = &right_jacobian_inverses_[first];
  jacobians->rotation[0].noalias() = A1P1.transpose() - D[1] * inverse[0].transpose();
  jacobians->rotation[1].noalias() = D[1] * inverse[0] - D[2] * inverse[1].transpose();
  jacobians->rotation[2].noalias() = D[2] * inverse[1] - D[3] * inverse[2].transpose();
  jacobians->rotation[3].noalias() = D[3] * inverse[2];
  if (!with_velocity) return value;

  Eigen::Matrix3d V[4];
  V[1] = basis.lambda_dot[1] * P1.transpose();
  Eigen::Matrix3d inner = Hat(turned_2) * M[2];
  inner.diagonal().array() += basis.lambda_dot[2];
  V[2].noalias() = A[3].transpose() * inner;
  V[3].noalias() = Hat(turned_3) * M[3];
  V[3].diagonal().array() += basis.lambda_dot[3];
  jacobians->angular_velocity[0].noalias() = -V[1] * inverse[0].transpose();
  jacobians->angular_velocity[1].noalias() = V[1] * inverse[0] - V[2] * inverse[1].transpose();
  jacobians->angular_velocity[2].noalias() = V[2] * inverse[1] - V[3] * inverse[2].transpose();
  jacobians->angular_velocity[3].noalias() = V[3] * inverse[2];
  return value;
}

}  // namespace mlic
