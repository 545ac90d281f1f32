#include "mlic_core/uncertainty/imu_alignment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/layout.h"

namespace mlic::imu_alignment_test {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kPrior = 1.0 * kDegree;

// One LiDAR, whose rotation the gyroscope tells to gyroscope[a] deg about each axis, and the accelerometer
// against the LiDAR to accelerometer[a] deg.
class OneLidar : public testing::Test {
 protected:
  OneLidar() {
    state_.lidars.resize(1);
    state_.drives.resize(1);
    const UniformKnots knots = UniformKnots::Covering(0.0, 1.0, 0.5);
    state_.drives[0].trajectory = {
        So3Spline(knots, std::vector<Eigen::Quaterniond>(knots.count, Eigen::Quaterniond::Identity())),
        PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()))};
    problem_.lidars.resize(1);
  }
  AlignmentReview Review(const Eigen::Vector3d& gyroscope, const Eigen::Vector3d& accelerometer,
                         bool tried = false) {
    const Layout layout(state_, false);
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
    information.diagonal().setConstant(1e8);
    const int rotation = Layout::Lidar(0), alignment = layout.alignment;
    for (int a = 0; a < 3; ++a) {
      const double of_gyroscope = std::pow(gyroscope[a] * kDegree, -2);
      const double of_accelerometer = std::pow(accelerometer[a] * kDegree, -2);
      information(rotation + a, rotation + a) = of_gyroscope + of_accelerometer;
      information(alignment + a, alignment + a) = of_accelerometer;
      information(rotation + a, alignment + a) = information(alignment + a, rotation + a) = -of_accelerometer;
    }
    return ReviewAlignment(problem_, state_, information, kPrior, tried);
  }

  JointProblem problem_;
  CalibrationState state_;
};

TEST_F(OneLidar, WhatIsShownIsFree) {
  const AlignmentReview review = Review({0.01, 0.02, 0.03}, {0.05, 0.05, 0.05});
  EXPECT_LT(review.held.norm(), 1e-9);
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(std::sqrt(review.covariance(a, a)), std::hypot(0.01 * (a + 1), 0.05) * kDegree, 1e-6);
  }
}

TEST_F(OneLidar, WhatIsNotShownIsHeldWithTheDoubtOfThePrior) {
  const AlignmentReview review = Review({0.01, 0.01, 20.0}, {0.05, 2.0, 0.01});
  EXPECT_NEAR(review.held(0, 0), 0.0, 1e-6);
  EXPECT_NEAR(review.held(1, 1), 1.0, 1e-6);
  EXPECT_NEAR(review.held(2, 2), 1.0, 1e-6);
  EXPECT_NEAR(std::sqrt(review.covariance(1, 1)), kDegree, 1e-4);
  EXPECT_NEAR(std::sqrt(review.covariance(2, 2)), kDegree, 1e-4);
}

// A car's heading: its accelerometer tells it ten times better than its gyroscope.
TEST_F(OneLidar, AnAxisThatSensorsRestOnIsTriedAndTakenBack) {
  const Eigen::Vector3d gyroscope(0.01, 0.01, 0.1), accelerometer(0.05, 0.05, 0.01);
  EXPECT_LT(Review(gyroscope, accelerometer).held.norm(), 1e-9);
  problem_.imu.alignment_held.setZero();
  state_.accelerometer_matrix = ExpMatrix(Eigen::Vector3d(0.0, 0.0, 0.2 * kDegree));
  const AlignmentReview review = Review(gyroscope, accelerometer);
  EXPECT_TRUE(review.taken_back);
  EXPECT_NEAR(review.held(2, 2), 1.0, 1e-6);
  EXPECT_NEAR(review.held.trace(), 1.0, 1e-6);
  problem_.imu.alignment_held = review.held;
  EXPECT_NEAR(Review(gyroscope, accelerometer, true).held(2, 2), 1.0, 1e-6);
}

TEST_F(OneLidar, AnAxisThatSensorsRestOnStaysFreeWhereItIsOff) {
  problem_.imu.alignment_held.setZero();
  state_.accelerometer_matrix = ExpMatrix(Eigen::Vector3d(0.0, 0.0, 2.0 * kDegree));
  const AlignmentReview review = Review({0.01, 0.01, 0.1}, {0.05, 0.05, 0.01});
  EXPECT_FALSE(review.taken_back);
  EXPECT_LT(review.held.norm(), 1e-9);
}

}  // namespace
}  // namespace mlic::imu_alignment_test
