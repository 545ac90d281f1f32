#include "mlic_core/uncertainty/range_corrections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/uncertainty/range_errors.h"
#include "support/walls_around.h"

namespace mlic::range_corrections_test {
namespace {

TEST_F(WallsAround, OffsetIsFoundBesideThePlanesThatFollowIt) {
  constexpr double kError = 0.02;  // m, too long
  AddWalls(kError, kError, kError);
  const auto found =
      RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {{true, false, false, false}});
  ASSERT_TRUE(found);
  const double sigma = std::sqrt(found->covariance(0, 0));
  EXPECT_LT(sigma, 0.1 * kError);  // with planes and place as they were, 0.0001 m
  EXPECT_NEAR(found->steps[0][0], -kError, 4.0 * sigma);
  EXPECT_EQ(found->covariance(kRangeSlope, kRangeSlope), 0.0);
  ASSERT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_NEAR(state_.ranges[0].offset, -kError, 4.0 * sigma);
  EXPECT_EQ(state_.ranges[0].slope, 0.0);
  const LidarPoint point{Eigen::Vector3f(3.0f, 0.0f, 4.0f)};
  EXPECT_NEAR(CorrectedPoint(point, state_, 0).norm(), 5.0 + state_.ranges[0].offset, 1e-5);
}

// A slope goes with the corrections of rings, which leave it out, and ends with them.
TEST_F(WallsAround, SlopeEndsWithTheCorrectionsOfRings) {
  AddWalls(0.02, 0.02, 0.02);
  ASSERT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  state_.ranges[0].slope = 0.1;
  EXPECT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_EQ(state_.ranges[0].slope, 0.0);
}

// Rings that err by a millimetre each for itself leave no slope of centimetres.
TEST_F(WallsAround, SlopeIsAsSmallAsTheErrorsOfRingsLeaveIt) {
  AddWalls(0.0, 0.0, 0.0);
  for (PlaneObservation& o : problem_.drives[0].planes.observations) {
    o.position *= 1.0 + 0.02 * ElevationOf(o.position) / o.position.norm();
  }
  const auto slope = [&](float ring_error) {
    state_.rings = {RingCorrections(16, {ring_error, 0.0f})};
    state_.ranges = {{}};
    const auto found =
        RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {{true, true, false, true}});
    return found ? found->steps[0][kRangeSlope] : 0.0;
  };
  const double free = slope(0.03f);
  EXPECT_LT(free, -0.01);
  EXPECT_LT(std::abs(slope(1e-5f)), 0.1 * std::abs(free));
}

TEST_F(WallsAround, RangesThatAreRightStay) {
  AddWalls(0.0, 0.0, 0.0);
  EXPECT_FALSE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_EQ(state_.ranges[0].offset, 0.0);
}

TEST_F(WallsAround, OffsetsBeyondWhatLidarsErrByAreSaidAndNotCorrected) {
  AddWalls(0.2, 0.2, 0.2);
  EXPECT_FALSE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_EQ(state_.ranges[0].offset, 0.0);
  EXPECT_NEAR(ApparentOffsets(problem_, state_, 1.0).at(0), -0.2, 0.02);
}

// As of wide beams, and of foliage.
TEST_F(WallsAround, ErrorsOfObliquePointsAreNoneOfTheRanges) {
  AddWalls(0.0, 0.03, 0.0);
  EXPECT_FALSE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_EQ(state_.ranges[0].offset, 0.0);
}

TEST_F(WallsAround, ErrorsOfRoughGroundAreNoneOfTheRanges) {
  AddWalls(0.0, 0.0, 0.03);
  EXPECT_FALSE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_EQ(state_.ranges[0].offset, 0.0);
}

// It stays in the calibration, so this is as unsure as it would move without.
TEST_F(WallsAround, ErrorsOfRoughGroundAreDoubt) {
  AddWalls(0.0, 0.0, 0.03);
  const Eigen::MatrixXd scatter = ScatterOfRanges(problem_, state_, 1.0, walks_dropped_);
  const auto found =
      RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {{true, false, false, true}});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->steps[0][kRangeLevel], -0.03, 0.003);
  const Eigen::VectorXd moved_by = found->coupling.col(kRangeLevel) * found->steps[0][kRangeLevel];
  ASSERT_GT(moved_by.norm(), 0.0);
  EXPECT_LT((scatter - moved_by * moved_by.transpose()).norm(), 0.02 * scatter.norm());
  // What noise explains is none.
  EXPECT_LT(ScatterOfRanges(problem_, state_, 1e6, walks_dropped_).norm(), 1e-5 * scatter.norm());
}

// What two LiDARs differ by counts where neither errs beyond three sigmas by itself.
TEST_F(WallsAround, DifferentErrorsOfRoughGroundAreDoubt) {
  AddLevelErrors({0.01, -0.01});
  const FreeRanges free{true, false, false, true};
  const auto found = RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {free, free});
  ASSERT_TRUE(found);
  const Eigen::Index at = RangeErrors::Of(0, kRangeLevel);
  // As large as 2.6 sigmas of each, if residuals are so much alike.
  const double correlation = std::pow(found->steps[0][kRangeLevel] / 2.6, 2) / found->covariance(at, at);
  const Eigen::VectorXd moved_by =
      found->coupling.col(at) * found->steps[0][kRangeLevel] +
      found->coupling.col(RangeErrors::Of(1, kRangeLevel)) * found->steps[1][kRangeLevel];
  // Of the mean square along it.
  const auto share = [&](double with_correlation) {
    const Eigen::MatrixXd scatter = ScatterOfRanges(problem_, state_, with_correlation, walks_dropped_);
    return moved_by.dot(scatter * moved_by) * with_correlation / std::pow(moved_by.squaredNorm(), 2);
  };
  // A mean of some 0.8 of it, and the variance about that.
  EXPECT_NEAR(share(correlation), 0.8, 0.15);
  // With half as many sigmas there may be none; offsets of the ranges are still possible.
  EXPECT_LT(share(4.0 * correlation), 0.3);
}

// Two sigmas are not corrected, and yet may well be there: the calibration moves by them, by and large.
TEST_F(WallsAround, OffsetsThatAreNotCorrectedAreDoubt) {
  AddWalls(0.005, 0.005, 0.005);
  const auto found =
      RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {{true, false, false, true}});
  ASSERT_TRUE(found);
  const double offset = found->steps[0][kRangeOffset];
  EXPECT_NEAR(offset, -0.005, 0.001);
  const double correlation = std::pow(offset / 2.0, 2) / found->covariance(kRangeOffset, kRangeOffset);
  const Eigen::VectorXd moved_by = found->coupling.col(kRangeOffset) * offset;
  const Eigen::MatrixXd scatter = ScatterOfRanges(problem_, state_, correlation, walks_dropped_);
  const double share = moved_by.dot(scatter * moved_by) * correlation / std::pow(moved_by.squaredNorm(), 2);
  EXPECT_GT(share, 0.5);
  EXPECT_LT(share, 1.2);
}

// Ranges that are right may err by a part of what is known of them.
TEST_F(WallsAround, RangesThatAreRightAreLittleDoubt) {
  AddWalls(0.0, 0.0, 0.0);
  const auto found =
      RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {{true, false, false, true}});
  ASSERT_TRUE(found);
  const Eigen::VectorXd by_sigma =
      found->coupling.col(kRangeOffset) * std::sqrt(found->covariance(kRangeOffset, kRangeOffset));
  const Eigen::MatrixXd scatter = ScatterOfRanges(problem_, state_, 1.0, walks_dropped_);
  EXPECT_GT(scatter.trace(), 0.0);
  EXPECT_LT(scatter.trace(), by_sigma.squaredNorm());
}

TEST_F(WallsAround, NothingIsAskedOfHeldTrajectories) {
  AddWalls(0.02, 0.02, 0.02);
  EXPECT_FALSE(RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {{false, false, false, false}}));
  problem_.fix_trajectory = true;
  EXPECT_FALSE(RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {{true, false, false, false}}));
}

}  // namespace
}  // namespace mlic::range_corrections_test
