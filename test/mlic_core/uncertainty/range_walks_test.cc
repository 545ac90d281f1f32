#include "mlic_core/uncertainty/range_walks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/uncertainty/range_corrections.h"
#include "mlic_core/uncertainty/range_errors.h"
#include "support/walls_around.h"

namespace mlic::range_walks_test {
namespace {

TEST_F(WallsAround, WalkIsFoundWhereLidarsDiffer) {
  AddPaintedWalls({0.0, 0.02}, 0.0);
  ASSERT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_NEAR(state_.ranges[1].walk - state_.ranges[0].walk, 0.02, 0.002);
  EXPECT_NEAR(state_.ranges[0].walk, 0.0, 0.004) << "what both share is hardly told from the walls' relief";
  LidarPoint point{Eigen::Vector3f(3.0f, 0.0f, 4.0f)};
  point.intensity = static_cast<float>(state_.ranges[1].reference);
  const float usual = CorrectedPoint(point, state_, 1).norm();
  point.intensity *= 10.0f;
  EXPECT_NEAR(CorrectedPoint(point, state_, 1).norm(), usual + state_.ranges[1].walk, 1e-5);
  point.intensity *= 1e6f;
  EXPECT_NEAR(CorrectedPoint(point, state_, 1).norm(), usual + 2.0 * state_.ranges[1].walk, 1e-5)
      << "glints are no reason for a metre";
}

// 4 mm at 1.6 (walls being flat to 1 mm): not beyond three sigmas, but likelier than none, as LiDARs err by 1
// cm.
TEST_F(WallsAround, DifferenceOfWalksThatIsLikelierThanNoneIsCorrected) {
  AddPaintedWalls({0.0, 0.004}, 0.0);
  const FreeRanges free{true, false, true, true};
  const auto found = RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {free, free});
  ASSERT_TRUE(found);
  const Eigen::Index a = RangeErrors::Of(0, kRangeWalk), b = RangeErrors::Of(1, kRangeWalk);
  const Eigen::MatrixXd& C = found->covariance;
  const double correlation = 0.0012 * 0.0012 / (C(a, a) + C(b, b) - 2.0 * C(a, b));
  ASSERT_TRUE(CorrectRanges(problem_, correlation, &walks_dropped_, &state_));
  EXPECT_NEAR(state_.ranges[1].walk - state_.ranges[0].walk, 0.004, 0.0005);
}

// Its own alone, as bright patches that are seen at a slant echo as dark ones do.
TEST_F(WallsAround, WalkOfASingleLidarIsFound) {
  AddPaintedWalls({0.02}, 0.0);
  ASSERT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_NEAR(state_.ranges[0].walk, 0.02, 0.003);
}

// What only some of the planes show is theirs, not the receiver's.
TEST_F(WallsAround, WalkThatLevelPlanesDoNotShareIsHardlyCorrected) {
  AddPaintedWalls({0.0}, 0.0);
  PlaneAssociation& planes = problem_.drives[0].planes;
  for (std::size_t i = 0; i < planes.begin[2]; ++i) {
    PlaneObservation& o = planes.observations[i];
    o.position *= 1.0 - 0.02 * std::log10(o.intensity / 100.0) / o.position.norm();
  }
  const auto found =
      RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {{true, false, true, true}});
  ASSERT_TRUE(found);
  EXPECT_GT(std::abs(found->steps[0][kRangeWalk]), 0.01);
  CorrectRanges(problem_, 1.0, &walks_dropped_, &state_);
  EXPECT_LT(std::abs(state_.ranges[0].walk), 0.5 * std::abs(found->steps[0][kRangeWalk]));
}

// One that is too small to be shown may be there: the calibration moves by it, by and large.
TEST_F(WallsAround, WalksThatAreNotCorrectedAreDoubt) {
  AddPaintedWalls({0.002}, 0.0);
  const FreeRanges free{true, false, true, true};
  const auto found = RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {free});
  ASSERT_TRUE(found);
  const Eigen::Index walk = RangeErrors::Of(0, kRangeWalk);
  const double correlation = std::pow(found->steps[0][kRangeWalk] / 2.0, 2) / found->covariance(walk, walk);
  EXPECT_FALSE(CorrectRanges(problem_, correlation, &walks_dropped_, &state_));
  const Eigen::VectorXd moved_by = found->coupling.col(walk) * found->steps[0][kRangeWalk];
  const Eigen::MatrixXd scatter = ScatterOfRanges(problem_, state_, correlation, walks_dropped_);
  const double share = moved_by.dot(scatter * moved_by) * correlation / std::pow(moved_by.squaredNorm(), 2);
  EXPECT_GT(share, 0.5);
  EXPECT_LT(share, 2.0);
}

TEST_F(WallsAround, DarkPatchesThatLieDeeperAreNoWalk) {
  AddPaintedWalls({0.0, 0.0}, 0.01);
  EXPECT_FALSE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_EQ(state_.ranges[0].walk, 0.0);
}

// Of windows in a wall, the LiDAR of more noise takes more for the wall's: it seems to have a walk.
TEST_F(WallsAround, DarkPatchesThatLieDeeperToOneLidarAreDoubtOfItsWalk) {
  AddPaintedWalls({0.0, 0.0}, 0.0);
  AddRelief(0.01, {1});
  const FreeRanges free{true, false, true, true};
  const auto found = RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {free, free});
  ASSERT_TRUE(found);
  const double difference = std::abs(found->steps[1][kRangeWalk] - found->steps[0][kRangeWalk]);
  EXPECT_GT(difference, 0.003);
  EXPECT_GT(3.0 * MeasureDoubtOfWalks(RangeEquations(problem_, state_), 1.0).OfDifference(0, 1), difference);
  CorrectRanges(problem_, 1.0, &walks_dropped_, &state_);
  EXPECT_LT(std::abs(state_.ranges[1].walk - state_.ranges[0].walk), 0.001);
}

// A LiDAR that sees brighter things than the other has another usual intensity: the same wall is as deep.
TEST_F(WallsAround, ReliefIsOfSurfacesWhateverElseALidarSees) {
  constexpr double kRelief = 0.03;  // m for each power of ten
  AddWallsOnBothSides(kRelief);
  const FreeRanges free{true, false, true, true};
  const auto found = RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {free, free});
  ASSERT_TRUE(found);
  EXPECT_GT(found->references[1], 1.8 * found->references[0]);
  EXPECT_NEAR(found->steps[1][kRangeOffset] - found->steps[0][kRangeOffset], 0.0, 0.1 * kRelief);
}

TEST_F(WallsAround, WalksThatGrowTooLargeAreDropped) {
  AddPaintedWalls({0.0, 0.02}, 0.0);
  ASSERT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  state_.ranges[1].walk = 0.04;
  EXPECT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_TRUE(walks_dropped_);
  CorrectRanges(problem_, 1.0, &walks_dropped_, &state_);
  EXPECT_EQ(state_.ranges[0].walk, 0.0);
  EXPECT_EQ(state_.ranges[1].walk, 0.0);
  // What is not corrected is doubt.
  const Eigen::MatrixXd doubt = ScatterOfRanges(problem_, state_, 1.0, walks_dropped_);
  const FreeRanges level{false, false, false, true};
  const auto found = RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {level, level});
  ASSERT_TRUE(found);
  for (std::size_t l = 0; l < 2; ++l) {
    const Eigen::VectorXd moved = 0.01 * found->coupling.col(RangeErrors::Of(l, kRangeWalk));
    ASSERT_GT(moved.norm(), 0.0);
    EXPECT_GE(moved.dot(doubt * moved), std::pow(moved.squaredNorm(), 2));
  }
}

// They pass for a walk of all LiDARs together in part, by an amount that is not known.
TEST_F(WallsAround, DarkPatchesThatLieDeeperAreDoubtOfWalks) {
  AddPaintedWalls({0.0, 0.02}, 0.0);
  ASSERT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  const FreeRanges free{true, false, true, true};
  const auto found = RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {free, free});
  ASSERT_TRUE(found);
  const Eigen::VectorXd of_all = found->coupling.col(RangeErrors::Of(0, kRangeWalk)) +
                                 found->coupling.col(RangeErrors::Of(1, kRangeWalk));
  const auto doubt = [&] {
    return of_all.dot(ScatterOfRanges(problem_, state_, 1.0, walks_dropped_) * of_all);
  };
  const double before = doubt();
  AddRelief(0.02);
  EXPECT_GT(doubt(), 1.5 * before);
}

// So LiDARs are taken to err as usual in what they share; most of what they differ by stays, as relief of 5
// cm for each power of ten leaves that unsure by 1 cm.
TEST_F(WallsAround, WalksOfAllAreSmallWhereTheyCannotBeTold) {
  AddPaintedWalls({0.0, 0.02}, 0.0);
  AddRelief(0.05);
  const FreeRanges free{true, false, true, true};
  const auto found = RangeEquations(problem_, state_).Measure(RangeModel::kWhole, {free, free});
  ASSERT_TRUE(found);
  const double alone = std::abs(found->steps[0][kRangeWalk]);
  EXPECT_GT(alone, 0.008);
  const DoubtOfWalks doubt = MeasureDoubtOfWalks(RangeEquations(problem_, state_), 1.0);
  EXPECT_GT(doubt.Beside().minCoeff(), 0.09 * doubt.common) << "relief is not seen alike by all";
  ASSERT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_NEAR(doubt.Beside().norm(), 0.01, 0.003);
  EXPECT_LT(std::abs(state_.ranges[0].walk), 0.4 * alone);
  EXPECT_NEAR(state_.ranges[1].walk - state_.ranges[0].walk, 0.013, 0.002);
}

}  // namespace
}  // namespace mlic::range_walks_test
