#include "mlic_core/pipeline/joint_adjustment.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <limits>

#include "mlic_core/summary/checks.h"
#include "mlic_core/summary/result_assembly.h"
#include "support/simulated_input.h"

namespace mlic::joint_adjustment_test {
namespace {

constexpr int kMostAfterMoves = 30;

// The joint adjustment of a simulated hand-held drive after so many rounds have gone by.
class JointAdjustment : public testing::Test {
 protected:
  JointAdjustment()
      : input_(SimulateInput(ConfiguredSensors("handheld.yaml"),
                             DriveOptions(sim::Scenario::kHandheld, 8.0, 7), false)),
        context_{input_.rig, input_.dataset, observer_, {token_, [](double) {}, [](const auto&) {}}} {
    const std::vector<DriveOdometry> odometry{
        RunDriveOdometry(input_.rig, input_.dataset.drives[0], token_, [](double) {})};
    adjustment_ =
        StartAdjustment(input_.rig, input_.dataset, Initialize(input_.rig, input_.dataset, odometry, token_));
  }

  // off: how far the LiDAR is moved before.
  CalibrationResult ResultAfter(int rounds_done, const Eigen::Vector3d& off) {
    Adjustment adjustment = adjustment_;
    adjustment.state.lidars[0].T_imu_sensor.translation += off;
    adjustment.rounds.done = rounds_done;
    adjustment.rounds.last_move = rounds_done;
    adjustment.rounds.most_points = std::numeric_limits<std::size_t>::max();  // no growth
    adjustment = AdjustJointly(std::move(adjustment), context_, {});
    unsettled_ = adjustment.rounds.unsettled;
    MeasureUncertainty(context_, &adjustment);
    CalibrationResult result;
    AssembleResult(input_.rig, input_.dataset, adjustment, &result);
    return result;
  }

  CancellationToken token_;
  SimulatedInput input_;
  CalibrationObserver observer_;
  AdjustmentContext context_;
  Adjustment adjustment_;
  double unsettled_ = 0.0;
};

TEST_F(JointAdjustment, WhatStillMovesByMoreThanItsSigmaIsNotTrusted) {
  // Only the last round is left, and it brings the LiDAR back by many sigmas.
  const CalibrationResult result = ResultAfter(kMostAfterMoves - 1, {0.05, -0.05, 0.05});
  EXPECT_GT(unsettled_, 10.0);
  EXPECT_FALSE(result.Trusted());
  ASSERT_FALSE(result.reasons.empty());
  EXPECT_NE(result.reasons.front().find("has not converged"), std::string::npos) << result.reasons.front();
  ASSERT_FALSE(result.checks.empty());
  EXPECT_EQ(result.checks[0].name, "convergence");
  EXPECT_EQ(result.checks[0].value, unsettled_);
  EXPECT_FALSE(result.checks[0].Passed());
}

TEST_F(JointAdjustment, WhatHasSettledIsTrustedWithoutWarning) {
  const CalibrationResult result = ResultAfter(0, Eigen::Vector3d::Zero());
  EXPECT_EQ(unsettled_, 0.0);
  EXPECT_TRUE(result.Trusted());
  EXPECT_TRUE(result.warnings.empty());
  for (const QualityCheck& check : result.checks) EXPECT_TRUE(check.Passed()) << DescribeCheck(check);
}

TEST(MostRounds, GoOnAfterMovesAndWhileTheMapGrows) {
  JointRounds rounds;
  rounds.last_move = 3;
  EXPECT_EQ(MostRounds(rounds), 15);
  rounds.last_move = 20;
  EXPECT_EQ(MostRounds(rounds), 25);
  rounds.last_move = 30;
  EXPECT_EQ(MostRounds(rounds), kMostAfterMoves);
  rounds.last_growth = 29;
  EXPECT_EQ(MostRounds(rounds), 34);
  rounds.last_move = 33;
  EXPECT_EQ(MostRounds(rounds), 34) << "what moves on without growth comes to an end";
  rounds.last_move = rounds.last_growth = 70;
  EXPECT_EQ(MostRounds(rounds), 60);
  rounds.last_move = 12;
  EXPECT_EQ(MostRounds(rounds), 17) << "growth alone is no reason";
}

}  // namespace
}  // namespace mlic::joint_adjustment_test
