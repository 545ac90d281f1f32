#include "mlic_core/uncertainty/range_corrections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/common/random.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/uncertainty/range_errors.h"
#include "support/lidars_at_rest.h"

namespace mlic::range_corrections_test {
namespace {

constexpr int kSeconds = 10;
constexpr int kPoints = 400;     // of a second, on each wall
constexpr double kSigma = 0.01;  // m
constexpr double kReflectances[] = {0.05, 0.25, 0.6};

// A LiDAR at rest that sees two walls and a ceiling at right angles with a view of 100 deg towards each.
class WallsAround : public testing::Test {
 protected:
  WallsAround() { PlaceAtRest(kSeconds, 1, &dataset_, &problem_, &state_); }

  // m: of points that meet a wall at less than 45 deg, of others on walls, of those on the ceiling.
  void AddWalls(double steep_error, double oblique_error, double level_error) {
    Random random(7);
    for (int axis = 0; axis < 3; ++axis) {
      AddPlane(axis);
      AddPoints(axis, 0, &random, [&](const Eigen::Vector3d&, double cosine) -> Echo {
        return {axis == 2 ? level_error : 2.0 * cosine * cosine > 1.0 ? steep_error : oblique_error, 0.0};
      });
    }
    SolveJointProblem(problem_, 5, CancellationToken(), &state_);
  }

  // m, of a LiDAR each: of its points on the ceiling.
  void AddLevelErrors(const std::vector<double>& errors) {
    AddWallsSeenBy(errors.size(), 9, [&](int axis, std::size_t l, const Eigen::Vector3d&, double) -> Echo {
      return {axis == 2 ? errors[l] : 0.0, 0.0};
    });
  }

  // The same walls, patches of them bright, grey and dark, seen by a LiDAR for each walk (m for each power of
  // ten). relief: m, by which dark patches lie deeper.
  void AddPaintedWalls(const std::vector<double>& walks, double relief) {
    const auto echo_of = [&](int, std::size_t l, const Eigen::Vector3d& point, double cosine) -> Echo {
      const int paint = (static_cast<int>(std::floor(point.sum())) % 3 + 3) % 3;
      const double strength = kReflectances[paint] * cosine;
      return {(paint == 0 ? relief / cosine : 0.0) - walks[l] * std::log10(strength), 100.0 * strength};
    };
    AddWallsSeenBy(walks.size(), 8, echo_of);
  }

  // m, by which dark patches of painted walls lie deeper than before.
  void AddRelief(double relief) {
    for (PlaneObservation& o : problem_.drives[0].planes.observations) {
      const bool dark = o.intensity < 110.0 * kReflectances[0] * o.cos_incidence;
      o.position *= 1.0 + (dark ? relief / o.cos_incidence : 0.0) / o.position.norm();
    }
  }

 private:
  struct Echo {
    double error;  // of the range, m
    double intensity;
  };

  // echo_of: the wall's axis, the LiDAR, a point and the cosine of its incidence.
  template <typename EchoOf>
  void AddWallsSeenBy(std::size_t lidars, std::uint64_t seed, const EchoOf& echo_of) {
    state_.lidars.resize(lidars);
    problem_.lidars.resize(lidars);
    Random random(seed);
    for (int axis = 0; axis < 3; ++axis) {
      AddPlane(axis);
      for (std::size_t l = 0; l < lidars; ++l) {
        AddPoints(axis, l, &random, [&](const Eigen::Vector3d& point, double cosine) {
          return echo_of(axis, l, point, cosine);
        });
      }
    }
    SolveJointProblem(problem_, 5, CancellationToken(), &state_);
  }

  void AddPlane(int axis) {
    PlaneAssociation& planes = problem_.drives[0].planes;
    MapPlane plane;
    plane.plane = {-Eigen::Vector3d::Unit(axis), -5.0};
    plane.center = 5.0 * Eigen::Vector3d::Unit(axis);
    planes.planes.push_back(plane);
    planes.begin.push_back(planes.observations.size());
  }

  // On the last plane. echo_of: a point and the cosine of its incidence.
  template <typename EchoOf>
  void AddPoints(int axis, std::size_t lidar, Random* random, const EchoOf& echo_of) {
    PlaneAssociation& planes = problem_.drives[0].planes;
    for (int k = 0; k < kSeconds * kPoints; ++k) {
      Eigen::Vector3d point;
      point[axis] = 5.0;
      point[(axis + 1) % 3] = random->Uniform(-6.0, 6.0);
      point[(axis + 2) % 3] = random->Uniform(-6.0, 6.0);
      const double cosine = 5.0 / point.norm();
      const Echo echo = echo_of(point, cosine);
      point *= 1.0 + (echo.error + kSigma * random->Normal()) / point.norm();
      planes.observations.push_back({point.cast<float>(), static_cast<float>(kSigma),
                                     static_cast<float>(cosine), static_cast<float>(echo.intensity),
                                     static_cast<std::int32_t>(lidar), 0,
                                     kSeconds * k / (1.0 * kSeconds * kPoints)});
    }
    planes.begin.back() = planes.observations.size();
  }

 protected:
  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;
  bool walks_dropped_ = false;
};

TEST_F(WallsAround, OffsetIsFoundBesideThePlanesThatFollowIt) {
  constexpr double kError = 0.02;  // m, too long
  AddWalls(kError, kError, kError);
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {{true, false, false, false}});
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
    const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {{true, true, false, true}});
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
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {{true, false, false, true}});
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
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {free, free});
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
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {{true, false, false, true}});
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
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {{true, false, false, true}});
  ASSERT_TRUE(found);
  const Eigen::VectorXd by_sigma =
      found->coupling.col(kRangeOffset) * std::sqrt(found->covariance(kRangeOffset, kRangeOffset));
  const Eigen::MatrixXd scatter = ScatterOfRanges(problem_, state_, 1.0, walks_dropped_);
  EXPECT_GT(scatter.trace(), 0.0);
  EXPECT_LT(scatter.trace(), by_sigma.squaredNorm());
}

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
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {{true, false, true, true}});
  ASSERT_TRUE(found);
  EXPECT_GT(std::abs(found->steps[0][kRangeWalk]), 0.01);
  CorrectRanges(problem_, 1.0, &walks_dropped_, &state_);
  EXPECT_LT(std::abs(state_.ranges[0].walk), 0.5 * std::abs(found->steps[0][kRangeWalk]));
}

// One that is too small to be shown may be there: the calibration moves by it, by and large.
TEST_F(WallsAround, WalksThatAreNotCorrectedAreDoubt) {
  AddPaintedWalls({0.002}, 0.0);
  const FreeRanges free{true, false, true, true};
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {free});
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
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {level, level});
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
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {free, free});
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

// So LiDARs are taken to err as usual in what they share, and what they differ by stays.
TEST_F(WallsAround, WalksOfAllAreSmallWhereTheyCannotBeTold) {
  AddPaintedWalls({0.0, 0.01}, 0.0);
  AddRelief(0.05);
  const FreeRanges free{true, false, true, true};
  const auto found = MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {free, free});
  ASSERT_TRUE(found);
  const double alone = std::abs(found->steps[0][kRangeWalk]);
  EXPECT_GT(alone, 0.008);
  ASSERT_TRUE(CorrectRanges(problem_, 1.0, &walks_dropped_, &state_));
  EXPECT_LT(std::abs(state_.ranges[0].walk), 0.3 * alone);
  EXPECT_NEAR(state_.ranges[1].walk - state_.ranges[0].walk, 0.01, 0.002);
}

TEST_F(WallsAround, NothingIsAskedOfHeldTrajectories) {
  AddWalls(0.02, 0.02, 0.02);
  EXPECT_FALSE(MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {{false, false, false, false}}));
  problem_.fix_trajectory = true;
  EXPECT_FALSE(MeasureRangeErrors(problem_, state_, RangeModel::kWhole, {{true, false, false, false}}));
}

}  // namespace
}  // namespace mlic::range_corrections_test
