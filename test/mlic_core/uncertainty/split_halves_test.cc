#include "mlic_core/uncertainty/split_halves.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "mlic_core/common/significance.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

// Values of tables of the distributions.
TEST(Significance, OfSumsOfSquaresIsThatOfOneNormalVariable) {
  EXPECT_NEAR(EquivalentDeviation(9.0, 1), 3.0, 1e-6);
  EXPECT_NEAR(EquivalentDeviation(13.816, 2), 3.2905, 1e-3);  // p = 0.001
  EXPECT_NEAR(EquivalentDeviation(16.266, 3), 3.2905, 1e-3);
  EXPECT_NEAR(EquivalentDeviation(34.528, 13), 3.2905, 1e-3);
  EXPECT_NEAR(EquivalentDeviation(1e4, 1), 100.0, 0.01);
  EXPECT_NEAR(EquivalentDeviation(0.0, 3), 0.0, 1e-9);
  for (const double squares : {599.0, 601.0}) {  // on either side of the far tail
    EXPECT_NEAR(EquivalentDeviation(squares, 4), 24.12, 0.04);
  }
}

TEST(Significance, OfSigmasThatAreInDoubtIsStudents) {
  EXPECT_NEAR(StudentDeviation(0.05, 10), 2.2281, 1e-3);
  EXPECT_NEAR(StudentDeviation(0.001, 20), 3.8495, 1e-3);
}

DriveState TurningFrom(double begin, double end) {
  constexpr double kSpacing = 0.1, kRate = 0.5, kDuration = 20.0;
  const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, kSpacing);
  std::vector<Eigen::Quaterniond> rotations;
  for (int k = 0; k < knots.count; ++k) {
    const double time = std::clamp(knots.ControlPointTime(k), begin, end);
    rotations.push_back(ExpQuaternion({0.0, 0.0, kRate * (time - begin)}));
  }
  DriveState drive;
  drive.trajectory.rotation = So3Spline(knots, rotations);
  drive.trajectory.position =
      PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()));
  return drive;
}

TEST(CutByTurning, LeavesHalfOfTheTurningOnEitherSide) {
  CalibrationState state;
  state.drives = {TurningFrom(12.0, 18.0)};
  const Halves halves = CutByTurning(state);
  ASSERT_EQ(halves.first.size(), 1u);
  EXPECT_EQ(halves.first[0].start, 0.0);
  EXPECT_NEAR(halves.first[0].end, 15.0, 0.1);
  EXPECT_EQ(halves.second[0].start, halves.first[0].end);
  EXPECT_EQ(halves.second[0].end, 20.0);
}

TEST(CutByTurning, LeavesWholeDrivesTogether) {
  CalibrationState state;
  state.drives = {TurningFrom(0.0, 4.0), TurningFrom(0.0, 20.0), TurningFrom(19.0, 20.0)};
  const Halves halves = CutByTurning(state);
  EXPECT_EQ(halves.first[0].Duration(), 20.0);
  EXPECT_EQ(halves.second[0].Duration(), 0.0);
  EXPECT_NEAR(halves.first[1].end, 8.5, 0.1);
  EXPECT_EQ(halves.first[2].Duration(), 0.0);
  EXPECT_EQ(halves.second[2].Duration(), 20.0);
}

}  // namespace
}  // namespace mlic
