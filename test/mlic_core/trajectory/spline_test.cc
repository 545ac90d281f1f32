#include <gtest/gtest.h>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic::spline_test {
namespace {

So3Spline RandomRotationSpline(std::uint64_t seed, double step) {
  Random random(seed);
  const UniformKnots knots{0.3, 0.07, 9};
  std::vector<Eigen::Quaterniond> control_points;
  Eigen::Quaterniond q = ExpQuaternion(Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()));
  for (int j = 0; j < knots.count; ++j) {
    control_points.push_back(q);
    q = q * ExpQuaternion(step * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()));
  }
  return So3Spline(knots, control_points);
}

So3Spline Perturbed(const So3Spline& spline, int j, const Eigen::Vector3d& delta) {
  auto control_points = spline.control_points();
  control_points[j] = control_points[j] * ExpQuaternion(delta);
  return So3Spline(spline.knots(), control_points);
}

TEST(So3Spline, DerivativesAgreeWithNumericOnes) {
  for (const double step : {1e-3, 0.1, 0.6}) {
    const So3Spline spline = RandomRotationSpline(7, step);
    const double h = 1e-5;
    for (double t = 0.31; t < 0.7; t += 0.0171) {
      const Eigen::Vector3d numeric_velocity =
          Log(spline.Rotation(t - h).conjugate() * spline.Rotation(t + h)) / (2.0 * h);
      EXPECT_LT((spline.AngularVelocity(t) - numeric_velocity).norm(),
                1e-6 * (1.0 + numeric_velocity.norm()));
      const Eigen::Vector3d numeric_acceleration =
          (spline.AngularVelocity(t + h) - spline.AngularVelocity(t - h)) / (2.0 * h);
      EXPECT_LT((spline.AngularAcceleration(t) - numeric_acceleration).norm(),
                1e-5 * (1.0 + numeric_acceleration.norm()));
    }
  }
}

TEST(So3Spline, JacobiansAgreeWithNumericOnes) {
  for (const double step : {1e-3, 0.1, 0.6}) {
    const So3Spline spline = RandomRotationSpline(11, step);
    const double h = 1e-6;
    for (double t = 0.31; t < 0.7; t += 0.0271) {
      const SplineBasis basis(spline.knots(), t);
      So3Spline::Jacobians J;
      const So3Spline::Value value = spline.Evaluate(basis, true, &J);
      EXPECT_LT((value.rotation - spline.Rotation(t).toRotationMatrix()).norm(), 1e-14);
      EXPECT_LT((value.angular_velocity - spline.Evaluate(basis).angular_velocity).norm(), 1e-13);
      for (int k = 0; k < 4; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
          const Eigen::Vector3d e = h * Eigen::Vector3d::Unit(axis);
          const So3Spline plus = Perturbed(spline, basis.first + k, e);
          const So3Spline minus = Perturbed(spline, basis.first + k, -e);
          const Eigen::Vector3d rotation = Log(minus.Rotation(t).conjugate() * plus.Rotation(t)) / (2.0 * h);
          EXPECT_LT((rotation - J.rotation[k].col(axis)).norm(), 1e-7);
          const Eigen::Vector3d velocity = (plus.AngularVelocity(t) - minus.AngularVelocity(t)) / (2.0 * h);
          EXPECT_LT((velocity - J.angular_velocity[k].col(axis)).norm(), 1e-6 * (1.0 + velocity.norm()));
        }
      }
    }
  }
}

TEST(So3Spline, ConstantRotationHasNoVelocity) {
  const UniformKnots knots{0.0, 0.1, 6};
  const Eigen::Quaterniond q = ExpQuaternion({0.3, -2.0, 1.0});
  const So3Spline spline(knots, std::vector<Eigen::Quaterniond>(6, q));
  EXPECT_LT(AngleBetween(spline.Rotation(0.17), q), 1e-14);
  EXPECT_LT(spline.AngularVelocity(0.17).norm(), 1e-12);
}

TEST(PositionSpline, ReproducesCubicMotionAndItsDerivatives) {
  // Control points of a cubic are its blossom; for p(t) = t it is the control point's time.
  const UniformKnots knots = UniformKnots::Covering(1.0, 2.05, 0.1);
  EXPECT_EQ(knots.Segments(), 11);
  std::vector<Eigen::Vector3d> control_points;
  for (int j = 0; j < knots.count; ++j) {
    const double t = knots.ControlPointTime(j);
    control_points.emplace_back(t, t * t - knots.spacing * knots.spacing / 3.0, 2.0);
  }
  const PositionSpline spline(knots, control_points);
  for (double t = 1.0; t < 2.1; t += 0.033) {
    const SplineBasis basis(knots, t);
    EXPECT_LT((spline.Position(basis) - Eigen::Vector3d(t, t * t, 2.0)).norm(), 1e-13);
    EXPECT_LT((spline.Velocity(basis) - Eigen::Vector3d(1.0, 2.0 * t, 0.0)).norm(), 1e-11);
    EXPECT_LT((spline.Acceleration(basis) - Eigen::Vector3d(0.0, 2.0, 0.0)).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace mlic::spline_test
