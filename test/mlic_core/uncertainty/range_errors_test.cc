#include "mlic_core/uncertainty/range_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/common/random.h"
#include "mlic_core/problem/joint_solver.h"

namespace mlic {
namespace {

constexpr int kSeconds = 10;
constexpr int kPoints = 400;     // of a second, on each wall
constexpr double kSigma = 0.01;  // m

// A LiDAR at rest that sees two walls and a ceiling at right angles with a view of 100 deg towards each.
class WallsAround : public testing::Test {
 protected:
  WallsAround() {
    const UniformKnots knots = UniformKnots::Covering(-0.5, kSeconds + 0.5, 0.5);
    DriveState drive;
    drive.trajectory.rotation =
        So3Spline(knots, std::vector<Eigen::Quaterniond>(knots.count, Eigen::Quaterniond::Identity()));
    drive.trajectory.position =
        PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()));
    state_.drives = {drive};
    state_.lidars.resize(1);
    dataset_.drives.resize(1);
    for (int i = 0; i < 50 * kSeconds; ++i) {
      dataset_.drives[0].imu.push_back({i / 50.0, Eigen::Vector3d::Zero(), -state_.Gravity()});
    }
    problem_.dataset = &dataset_;
    problem_.drives.resize(1);
    problem_.drives[0].imu_sigma.usual = {Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(3e-4)};
    problem_.lidars.resize(1);
    problem_.drives[0].planes.begin = {0};
  }

  // m: of points that meet a wall at less than 45 deg, of others on walls, of those on the ceiling.
  void AddWalls(double steep_error, double oblique_error, double level_error) {
    PlaneAssociation& planes = problem_.drives[0].planes;
    Random random(7);
    for (int axis = 0; axis < 3; ++axis) {
      MapPlane plane;
      plane.plane = {-Eigen::Vector3d::Unit(axis), -5.0};
      plane.center = 5.0 * Eigen::Vector3d::Unit(axis);
      planes.planes.push_back(plane);
      for (int k = 0; k < kSeconds * kPoints; ++k) {
        Eigen::Vector3d point;
        point[axis] = 5.0;
        point[(axis + 1) % 3] = random.Uniform(-6.0, 6.0);
        point[(axis + 2) % 3] = random.Uniform(-6.0, 6.0);
        const double cosine = 5.0 / point.norm();
        const double error = axis == 2                     ? level_error
                             : 2.0 * cosine * cosine > 1.0 ? steep_error
                                                           : oblique_error;
        point *= 1.0 + (error + kSigma * random.Normal()) / point.norm();
        planes.observations.push_back({point.cast<float>(), static_cast<float>(kSigma),
                                       static_cast<float>(cosine), 0.0f, 0, 0,
                                       kSeconds * k / (1.0 * kSeconds * kPoints)});
      }
      planes.begin.push_back(planes.observations.size());
    }
    SolveJointProblem(problem_, 5, CancellationToken(), &state_);
  }

  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;
};

TEST_F(WallsAround, OffsetIsFoundBesideThePlanesThatFollowIt) {
  constexpr double kError = 0.03;  // m, too long
  AddWalls(kError, kError, kError);
  const auto found =
      MeasureRangeErrors(problem_, state_, RangeModel::kOffsetAndSlope, {{true, false, false}});
  ASSERT_TRUE(found);
  const double sigma = std::sqrt(found->covariance(0, 0));
  EXPECT_LT(sigma, 0.1 * kError);  // with planes and place as they were, 0.0001 m
  EXPECT_NEAR(found->steps[0][0], -kError, 4.0 * sigma);
  EXPECT_EQ(found->covariance(1, 1), 0.0);
  ASSERT_TRUE(CorrectRanges(problem_, 1.0, &state_));
  EXPECT_NEAR(state_.ranges[0].offset, -kError, 4.0 * sigma);
  EXPECT_EQ(state_.ranges[0].slope, 0.0);
  const LidarPoint point{Eigen::Vector3f(3.0f, 0.0f, 4.0f)};
  EXPECT_NEAR(CorrectedPoint(point, state_, 0).norm(), 5.0 + state_.ranges[0].offset, 1e-5);
}

TEST_F(WallsAround, RangesThatAreRightStay) {
  AddWalls(0.0, 0.0, 0.0);
  EXPECT_FALSE(CorrectRanges(problem_, 1.0, &state_));
  EXPECT_EQ(state_.ranges[0].offset, 0.0);
}

// As of wide beams, and of foliage.
TEST_F(WallsAround, ErrorsOfObliquePointsAreNoneOfTheRanges) {
  AddWalls(0.0, 0.03, 0.0);
  EXPECT_FALSE(CorrectRanges(problem_, 1.0, &state_));
  EXPECT_EQ(state_.ranges[0].offset, 0.0);
}

TEST_F(WallsAround, ErrorsOfRoughGroundAreNoneOfTheRanges) {
  AddWalls(0.0, 0.0, 0.03);
  EXPECT_FALSE(CorrectRanges(problem_, 1.0, &state_));
  EXPECT_EQ(state_.ranges[0].offset, 0.0);
}

// It stays in the calibration, so this is as unsure as it would move without.
TEST_F(WallsAround, ErrorsOfRoughGroundAreDoubt) {
  AddWalls(0.0, 0.0, 0.03);
  const Eigen::MatrixXd scatter = ScatterOfRanges(problem_, state_, 1.0);
  const auto found =
      MeasureRangeErrors(problem_, state_, RangeModel::kOffsetAndSlope, {{false, false, true}});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->steps[0][2], -0.03, 0.003);
  const Eigen::VectorXd moved_by = found->coupling.col(2) * found->steps[0][2];
  ASSERT_GT(moved_by.norm(), 0.0);
  EXPECT_LT((scatter - moved_by * moved_by.transpose()).norm(), 1e-6 * scatter.norm());
  // What noise explains is none.
  EXPECT_EQ(ScatterOfRanges(problem_, state_, 1e6).norm(), 0.0);
}

TEST_F(WallsAround, LevelPlanesWithoutErrorsAddNoDoubt) {
  AddWalls(0.0, 0.0, 0.0);
  EXPECT_EQ(ScatterOfRanges(problem_, state_, 1.0).norm(), 0.0);
}

TEST_F(WallsAround, NothingIsAskedOfHeldTrajectories) {
  AddWalls(0.02, 0.02, 0.02);
  EXPECT_FALSE(MeasureRangeErrors(problem_, state_, RangeModel::kOffsetAndSlope, {{false, false, false}}));
  problem_.fix_trajectory = true;
  EXPECT_FALSE(MeasureRangeErrors(problem_, state_, RangeModel::kOffsetAndSlope, {{true, false, false}}));
}

}  // namespace
}  // namespace mlic
