#include "mlic_core/problem/joint_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "mlic_core/common/error.h"

namespace mlic::joint_solver_test {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// A LiDAR that stands still in the corner of three planes, its trajectory held; its pose is to be found.
class StandingLidar : public testing::Test {
 protected:
  StandingLidar() {
    // Maps (1, 1, 1) to a multiple of (1, 1, 0).
    const Eigen::Quaterniond R_map_imu =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d(1.0, 1.0, 1.0), Eigen::Vector3d(1.0, 1.0, 0.0));
    const UniformKnots knots = UniformKnots::Covering(0.0, 1.0, 0.1);
    DriveState drive;
    drive.trajectory.rotation = So3Spline(knots, std::vector<Eigen::Quaterniond>(knots.count, R_map_imu));
    drive.trajectory.position =
        PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()));
    state_.drives = {drive};
    state_.lidars.resize(1);
    dataset_.drives.resize(1);
    problem_.dataset = &dataset_;
    problem_.drives.resize(1);
    problem_.lidars.resize(1);
    problem_.fix_trajectory = true;
    PlaneAssociation& planes = problem_.drives[0].planes;
    planes.begin = {0};
    for (int axis = 0; axis < 3; ++axis) {
      MapPlane plane;
      plane.plane = {Eigen::Vector3d::Unit(axis), 5.0};
      plane.center = 5.0 * Eigen::Vector3d::Unit(axis);
      planes.planes.push_back(plane);
      for (int k = 0; k < 9; ++k) {
        Eigen::Vector3d in_map;
        in_map[axis] = 5.0;
        in_map[(axis + 1) % 3] = k % 3 - 1.0;
        in_map[(axis + 2) % 3] = k / 3 - 1.0;
        const Eigen::Vector3f position = (R_map_imu.conjugate() * in_map).cast<float>();
        planes.observations.push_back({position, kSigma, 1.0f, 0.0f, 0, 0, 0.5});
      }
      planes.begin.push_back(planes.observations.size());
    }
  }
  SolveSummary Solve(int iterations) {
    return SolveJointProblem(problem_, iterations, CancellationToken(), &state_);
  }
  // One step leads to a guess whose coordinates in the map overflow: residuals there are infinity times zero.
  void GuessBeyondNumbers() {
    for (PlaneObservation& o : problem_.drives[0].planes.observations) o.sigma = 1e6f;
    ExtrinsicGuess guess;
    guess.T_imu_sensor.translation.setConstant(1.5e308);
    guess.sigma_translation.setOnes();
    problem_.lidars[0].guess = guess;
  }

  static constexpr float kSigma = 0.01f;
  Dataset dataset_;
  JointProblem problem_;
  CalibrationState state_;
};

TEST_F(StandingLidar, StaysWhereItIsRight) {
  const SolveSummary summary = Solve(6);
  EXPECT_TRUE(summary.solved);
  EXPECT_LT(summary.last_cost, 1e-6);
  EXPECT_LT(state_.lidars[0].T_imu_sensor.translation.norm(), 1e-6);
}

TEST_F(StandingLidar, AStepToWhereTheCostIsNotANumberIsTakenBack) {
  GuessBeyondNumbers();
  for (const int iterations : {1, 2, 6}) {
    const SolveSummary summary = Solve(iterations);
    EXPECT_EQ(summary.iterations, iterations);
    EXPECT_LT(summary.last_cost, 1e-9) << iterations;
    EXPECT_GT(summary.refused_step.size(), 0) << iterations;
    EXPECT_TRUE(IsFinite(state_)) << iterations;
    EXPECT_EQ(state_.lidars[0].T_imu_sensor.translation.norm(), 0.0) << iterations;
  }
}

TEST_F(StandingLidar, WhatIsHeldStandsAtTheGuessThoughTheDataResist) {
  // A second LiDAR, which does not move, sees the same planes.
  state_.lidars.resize(2);
  problem_.lidars.resize(2);
  problem_.lidars[1].fixed = true;
  PlaneAssociation& planes = problem_.drives[0].planes;
  const PlaneAssociation seen_once = planes;
  planes.observations.clear();
  planes.begin = {0};
  for (std::size_t p = 0; p < planes.planes.size(); ++p) {
    for (const int lidar : {0, 1}) {
      for (std::size_t k = seen_once.begin[p]; k < seen_once.begin[p + 1]; ++k) {
        planes.observations.push_back(seen_once.observations[k]);
        planes.observations.back().lidar = lidar;
      }
    }
    planes.begin.push_back(planes.observations.size());
  }
  ExtrinsicGuess guess;
  guess.T_imu_sensor.translation.z() = 0.3;
  guess.sigma_translation.setConstant(0.1);
  problem_.lidars[0].guess = guess;
  Eigen::VectorXd row = Eigen::VectorXd::Zero(2 * 7);
  row[5] = 1.0;
  problem_.held_translations = {row};
  const SolveSummary summary = Solve(6);
  EXPECT_GT(summary.last_cost, 100.0);
  EXPECT_NEAR(state_.lidars[0].T_imu_sensor.translation.z(), 0.3, 1e-6);
}

TEST_F(StandingLidar, EquationsWithoutSolutionAreSaid) {
  ExtrinsicGuess guess;
  guess.T_imu_sensor.translation.setConstant(kNotANumber);
  problem_.lidars[0].guess = guess;
  const SolveSummary summary = Solve(3);
  EXPECT_FALSE(summary.solved);
  EXPECT_EQ(summary.information.size(), 0);
  EXPECT_TRUE(IsFinite(state_));
}

TEST_F(StandingLidar, AProblemOfOtherSensorsThanTheStatesThrows) {
  problem_.cameras.resize(1);
  EXPECT_THROW(Solve(3), InternalError);
}

TEST_F(StandingLidar, AStartWhoseCostIsNotANumberThrows) {
  problem_.drives[0].planes.observations[4].position.x() = static_cast<float>(kNotANumber);
  EXPECT_THROW(Solve(3), InternalError);
}

TEST(CalibrationState, IsFiniteLooksAtEveryPart) {
  CalibrationState state;
  EXPECT_TRUE(IsFinite(state));
  state.lidars.resize(2);
  state.cameras.resize(1);
  state.cameras[0].intrinsics.parameters = {1.0, 2.0};
  state.drives.resize(1);
  state.drives[0].trajectory.position =
      PositionSpline({0.0, 0.1, 4}, std::vector<Eigen::Vector3d>(4, Eigen::Vector3d::Zero()));
  EXPECT_TRUE(IsFinite(state));
  const auto spoiled = [&](const auto& spoil) {
    CalibrationState copy = state;
    spoil(&copy);
    return !IsFinite(copy);
  };
  EXPECT_TRUE(spoiled([](CalibrationState* s) { s->lidars[1].time_offset = kNotANumber; }));
  EXPECT_TRUE(spoiled([](CalibrationState* s) { s->lidars[0].T_imu_sensor.rotation.x() = kNotANumber; }));
  EXPECT_TRUE(spoiled([](CalibrationState* s) { s->cameras[0].intrinsics.parameters[1] = kNotANumber; }));
  EXPECT_TRUE(spoiled([](CalibrationState* s) { s->cameras[0].readout = INFINITY; }));
  EXPECT_TRUE(spoiled([](CalibrationState* s) { s->drives[0].bias.knots[0].z() = kNotANumber; }));
  EXPECT_TRUE(spoiled([](CalibrationState* s) { s->accelerometer_matrix(2, 1) = kNotANumber; }));
  EXPECT_TRUE(spoiled([](CalibrationState* s) {
    std::vector<Eigen::Vector3d> points(4, Eigen::Vector3d::Zero());
    points[2].y() = kNotANumber;
    s->drives[0].trajectory.position = PositionSpline({0.0, 0.1, 4}, points);
  }));
}

}  // namespace
}  // namespace mlic::joint_solver_test
