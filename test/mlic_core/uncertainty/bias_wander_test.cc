#include "mlic_core/uncertainty/bias_wander.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/problem/layout.h"
#include "support/lidars_at_rest.h"

namespace mlic::bias_wander_test {
namespace {

constexpr double kShown = 1e-4;  // rad/s and m/s^2, to which the data show the bias at each knot

// One LiDAR, whose rotation nothing but its prior holds, and one drive whose knots the data show one by one.
class WarmingImu : public testing::Test {
 protected:
  WarmingImu() {
    PlaceAtRest(20, 1, &dataset_, &problem_, &state_);
    state_.drives[0].bias = *CourseOf(state_.drives[0].bias, 0.0, 20.0);
    problem_.drives[0].bias_steps = kUnknownSteps;
  }
  // Of biases that wander by steps of these sigmas.
  BiasEvidence Evidence(double gyroscope, double accelerometer, std::uint64_t seed,
                        double scale = 1.0) const {
    const CalibrationEquations equations = Equations(gyroscope, accelerometer, seed, scale);
    return EvidenceOfWander(problem_, state_, equations, 0, scale);
  }
  CalibrationEquations Equations(double gyroscope, double accelerometer, std::uint64_t seed,
                                 double scale = 1.0) const {
    Random random(seed);
    const Layout layout(state_, false);
    CalibrationEquations equations;
    equations.information = Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
    equations.information.diagonal().setConstant(1e8);
    equations.gradient = equations.prior_gradient = Eigen::VectorXd::Zero(layout.calibration);
    const double information = 1.0 / (kShown * kShown);
    BiasCourse::Bias bias = BiasCourse::Bias::Constant(0.003);
    for (std::size_t knot = 0; knot < state_.drives[0].bias.knots.size(); ++knot) {
      for (int a = 0; a < Layout::kOfBias; ++a) {
        const int at = layout.Bias(0, static_cast<int>(knot)) + a;
        equations.information(at, at) = information;
        equations.gradient[at] = -information * (bias[a] + std::sqrt(scale) * kShown * random.Normal());
        bias[a] += (a < 3 ? gyroscope : accelerometer) * random.Normal();
      }
    }
    return equations;
  }
  // The doubt of the LiDAR's rotation about x, which the last knot of the gyroscope's x axis looks like.
  double DoubtOfRotation(CalibrationEquations equations) const {
    const Layout layout(state_, false);
    const int last = layout.Bias(0, static_cast<int>(state_.drives[0].bias.knots.size()) - 1);
    equations.information(0, last) = equations.information(last, 0) = 1.0;
    return ScatterOfWander(problem_, state_, equations, 0, 1.0)(0, 0);
  }

  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;
};

TEST_F(WarmingImu, ConstantBiasesDoNotWander) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    EXPECT_FALSE(Evidence(0.0, 0.0, seed).IsShown()) << "seed " << seed;
    EXPECT_FALSE(Evidence(0.0, 0.0, seed, 9.0).IsShown()) << "seed " << seed;
  }
}

TEST_F(WarmingImu, StepsHaveTheirSize) {
  double squares = 0.0;
  constexpr int kDraws = 40;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const BiasEvidence evidence = Evidence(4e-4, 0.0, seed);
    EXPECT_TRUE(evidence.IsShown()) << "seed " << seed;
    EXPECT_LT(evidence.steps.accelerometer, 2e-4);  // two sigmas of what the data show
    squares += evidence.steps.gyroscope * evidence.steps.gyroscope;
  }
  EXPECT_NEAR(std::sqrt(squares / kDraws), 4e-4, 0.4e-4);
  EXPECT_NEAR(Evidence(0.0, 0.01, 1).steps.accelerometer, 0.01, 3e-3);
}

// A drift by five sigmas of what the data show of each knot, from the first to the last.
TEST_F(WarmingImu, AnEvenDriftIsShown) {
  const Layout layout(state_, false);
  CalibrationEquations equations;
  equations.information =
      Eigen::MatrixXd::Identity(layout.calibration, layout.calibration) / (kShown * kShown);
  equations.gradient = equations.prior_gradient = Eigen::VectorXd::Zero(layout.calibration);
  const int last = static_cast<int>(state_.drives[0].bias.knots.size()) - 1;
  for (int knot = 0; knot <= last; ++knot) {
    for (int a = 0; a < 3; ++a) equations.gradient[layout.Bias(0, knot) + a] = -5.0 * knot / (last * kShown);
  }
  EXPECT_TRUE(EvidenceOfWander(problem_, state_, equations, 0, 1.0).IsShown());
  EXPECT_FALSE(EvidenceOfWander(problem_, state_, equations, 0, 25.0).IsShown());
}

TEST_F(WarmingImu, WhatWandersMoreThanBiasesDoIsNone) {
  EXPECT_FALSE(Evidence(0.0, 0.3, 1).IsShown());
  EXPECT_FALSE(Evidence(0.05, 0.0, 1).IsShown());
}

TEST_F(WarmingImu, WithoutEquationsHasNoEvidence) {
  EXPECT_EQ(EvidenceOfWander(problem_, state_, {}, 0, 1.0).gain, 0.0);
  EXPECT_EQ(ScatterOfWander(problem_, state_, {}, 0, 1.0).norm(), 0.0);
}

// Where one is shown, the other may have wandered by what the data do not show.
TEST_F(WarmingImu, StepsThatAreNotShownAreAsLargeAsTheyMayBe) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const BiasSteps steps = Evidence(0.0, 0.005, seed).steps;
    EXPECT_GT(steps.gyroscope, 0.1 * kShown) << "seed " << seed;
    EXPECT_LT(steps.gyroscope, 2.0 * kShown) << "seed " << seed;
  }
}

// The last knot's wander is the sum of all steps. From the wander that the data cannot show, a part of what
// they are good to, to what IMUs have at most where they show nothing.
TEST_F(WarmingImu, ConstantBiasesAreDoubtByWhatTheyMayWander) {
  const double well_shown = DoubtOfRotation(Equations(0.0, 0.0, 1));
  EXPECT_GT(std::sqrt(well_shown), 0.1 * kShown);
  EXPECT_LT(std::sqrt(well_shown), 2.0 * kShown);
  CalibrationEquations blind = Equations(0.0, 0.0, 1);
  blind.information *= 1e-8;
  blind.gradient *= 1e-8;
  const auto steps = static_cast<double>(state_.drives[0].bias.knots.size() - 1);
  // The mean of sigma^2 over sizes from 1e-5 to 1e-3, evenly in their logarithm.
  const double mean_square = 0.5 * 1e-6 / std::log(100.0);
  EXPECT_NEAR(DoubtOfRotation(blind), steps * mean_square, 0.2 * steps * mean_square);
}

TEST(CourseOfBiases, HasAFewKnotsAllAlike) {
  const BiasCourse constant({0.001, 0.0, 0.002}, {0.1, 0.0, 0.0});
  EXPECT_FALSE(CourseOf(constant, 0.0, 9.0).has_value());
  const BiasCourse minute = *CourseOf(constant, 3.0, 63.0);
  EXPECT_EQ(minute.knots.size(), 7u);
  EXPECT_NEAR(minute.spacing, 10.0, 1e-12);
  EXPECT_EQ(minute.start, 3.0);
  EXPECT_EQ(CourseOf(constant, 0.0, 600.0)->knots.size(), 21u);
  for (const BiasCourse::Bias& knot : minute.knots) EXPECT_EQ(knot, constant.knots[0]);
}

}  // namespace
}  // namespace mlic::bias_wander_test
