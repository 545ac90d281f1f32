#include "mlic_core/uncertainty/imu_alignment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/problem/layout.h"
#include "support/lidars_at_rest.h"

namespace mlic::imu_alignment_test {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kPrior = 1.0 * kDegree;

// One LiDAR, whose rotation the gyroscope tells to gyroscope[a] deg about each axis, and the accelerometer,
// which has its own rotation beside the LiDAR's, to accelerometer[a] deg.
class OneLidar : public testing::Test {
 protected:
  OneLidar() { PlaceAtRest(1, 1, &dataset_, &problem_, &state_); }
  AlignmentReview Review(const Eigen::Vector3d& gyroscope, const Eigen::Vector3d& accelerometer) {
    const Layout layout(state_, false);
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
    information.diagonal().setConstant(1e8);
    const int rotation = Layout::Lidar(0), alignment = layout.alignment;
    for (int a = 0; a < 3; ++a) {
      // By how much a turn of the alignment turns the axes against each of the two.
      const double of_axes = state_.accelerometer_axes(a, a);
      const auto add = [&](double sigma, double turn) {
        const double known = std::pow(sigma * kDegree, -2);
        information(rotation + a, rotation + a) += known;
        information(rotation + a, alignment + a) += turn * known;
        information(alignment + a, rotation + a) += turn * known;
        information(alignment + a, alignment + a) += turn * turn * known;
      };
      information(rotation + a, rotation + a) = information(alignment + a, alignment + a) = 0.0;
      add(gyroscope[a], -of_axes);
      add(accelerometer[a], 1.0 - of_axes);
    }
    return ReviewAlignment(problem_, state_, information, kPrior);
  }
  static double Sigma(const AlignmentReview& review, int axis) {
    return std::sqrt(review.covariance(axis, axis)) / kDegree;
  }

  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;
};

TEST_F(OneLidar, WhatTheDataShowHasTheirSigma) {
  const AlignmentReview review = Review({0.01, 0.02, 0.03}, {0.05, 0.05, 0.05});
  EXPECT_TRUE(review.shown.isIdentity(1e-9));
  EXPECT_LT(review.accelerometer_axes.norm(), 1e-9);
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(Sigma(review, a), std::hypot(0.01 * (a + 1), 0.05), 1e-4);
}

// About y the accelerometer shows nothing of the rotation, about z the gyroscope: a car's heading.
TEST_F(OneLidar, WhatIsNotShownHasThePriors) {
  const AlignmentReview review = Review({0.01, 0.01, 20.0}, {0.05, 20.0, 0.01});
  EXPECT_TRUE(review.shown.isApprox(Eigen::Vector3d(1.0, 0.0, 0.0).asDiagonal().toDenseMatrix(), 1e-6));
  EXPECT_NEAR(Sigma(review, 1), 1.0, 0.01);
  EXPECT_NEAR(Sigma(review, 2), 1.0, 0.01);
  // There the sensor's rotation is to the sensor that tells it.
  EXPECT_TRUE(
      review.accelerometer_axes.isApprox(Eigen::Vector3d(0.0, 0.0, 1.0).asDiagonal().toDenseMatrix(), 1e-6));
}

// A car's heading: its accelerometer tells it three times as well as its gyroscope.
TEST_F(OneLidar, AxesAreThoseOfTheSensorThatTellsTheRotationBest) {
  const Eigen::Vector3d gyroscope(0.01, 0.01, 0.15), accelerometer(0.05, 0.05, 0.05);
  const AlignmentReview review = Review(gyroscope, accelerometer);
  EXPECT_TRUE(review.shown.isIdentity(1e-9));
  const Eigen::Matrix3d heading = Eigen::Vector3d(0.0, 0.0, 1.0).asDiagonal();
  EXPECT_TRUE(review.accelerometer_axes.isApprox(heading, 1e-6));
  // And so they stay, in which axes they ever are.
  state_.accelerometer_axes = heading;
  EXPECT_TRUE(Review(gyroscope, accelerometer).accelerometer_axes.isApprox(heading, 1e-6));
  EXPECT_LT(Review({0.01, 0.01, 0.02}, accelerometer).accelerometer_axes.norm(), 1e-9);
}

TEST_F(OneLidar, WithoutInformationNothingIsShown) {
  const AlignmentReview review = ReviewAlignment(problem_, state_, {}, kPrior);
  EXPECT_EQ(review.shown.norm(), 0.0);
}

}  // namespace
}  // namespace mlic::imu_alignment_test
