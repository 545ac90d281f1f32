#include "mlic_core/sensors/bias_course.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/factors/imu_residual.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/joint_solver.h"

namespace mlic::bias_course_test {
namespace {

constexpr double kRate = 100.0, kDuration = 12.0;

BiasCourse TrueCourse() {
  BiasCourse course;
  course.start = 1.0;
  course.spacing = 4.0;
  course.knots.assign(3, BiasCourse::Bias::Zero());
  course.knots[0] << 0.010, -0.020, 0.005, 0.10, 0.20, -0.30;
  course.knots[1] << 0.012, -0.016, 0.005, 0.05, 0.26, -0.31;
  course.knots[2] << 0.009, -0.015, 0.008, 0.08, 0.21, -0.25;
  return course;
}

TEST(BiasCourse, IsStraightBetweenKnotsAndConstantBeyond) {
  const BiasCourse course = TrueCourse();
  EXPECT_EQ(course.Value(-3.0), course.knots[0]);
  EXPECT_EQ(course.Value(1.0), course.knots[0]);
  EXPECT_LT((course.Value(6.0) - (0.75 * course.knots[1] + 0.25 * course.knots[2])).norm(), 1e-15);
  EXPECT_LT((course.Value(9.0) - course.knots[2]).norm(), 1e-15);
  EXPECT_LT((course.Value(50.0) - course.knots[2]).norm(), 1e-15);
  EXPECT_LT((course.Mean() - (course.knots[0] + course.knots[1] + course.knots[2]) / 3.0).norm(), 1e-15);
  EXPECT_NEAR(course.Range()[0], std::hypot(0.001, 0.005, 0.003), 1e-12);
  EXPECT_TRUE(BiasCourse().IsConstant());
}

// Samples without noise of a rig whose poses are known: the course is found from none.
TEST(BiasCourse, IsFoundByTheSolve) {
  const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, 0.1);
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> positions;
  for (int k = 0; k < knots.count; ++k) {
    const double t = knots.ControlPointTime(k);
    rotations.push_back(
        ExpQuaternion({0.6 * std::sin(0.9 * t), 0.5 * std::sin(1.3 * t), 0.8 * std::sin(0.7 * t)}));
    positions.emplace_back(std::sin(0.8 * t), std::cos(1.1 * t), 0.3 * std::sin(1.7 * t));
  }
  CalibrationState state;
  state.drives.resize(1);
  state.drives[0].trajectory = {So3Spline(knots, rotations), PositionSpline(knots, positions)};
  state.drives[0].bias = TrueCourse();
  Dataset dataset;
  dataset.drives.resize(1);
  JointProblem problem;
  problem.dataset = &dataset;
  DriveTerms& terms = problem.drives.emplace_back();
  terms.imu_sigma.usual = {Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(1e-2)};
  terms.bias_steps = {1e3, 1e3};  // so that the prior does not pull
  terms.poses = {{}, 1e-4, 1e-3};
  const SplitSpline& trajectory = state.drives[0].trajectory;
  for (int i = 0; i < static_cast<int>(kDuration * kRate); ++i) {
    const double t = (i + 0.5) / kRate;
    ImuSample sample{t, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    const Eigen::Matrix<double, 6, 1> measured = ImuResidual::Evaluate(
        trajectory, {trajectory, t, 0.0}, state.Imu(0, t), state.Gravity(), sample, nullptr);
    sample.angular_velocity = measured.head<3>();
    sample.specific_force = measured.tail<3>();
    dataset.drives[0].imu.push_back(sample);
    if (i % 5 == 0) terms.poses.T_map_imu.push_back({t, trajectory.Pose(t)});
  }
  BiasCourse& found = state.drives[0].bias;
  for (BiasCourse::Bias& knot : found.knots) knot.setZero();
  const SolveSummary summary = SolveJointProblem(problem, 10, CancellationToken(), &state);
  EXPECT_TRUE(summary.solved);
  const BiasCourse truth = TrueCourse();
  for (std::size_t k = 0; k < 3; ++k) {
    // The prior of the first knot, 50 mrad/s about none, pulls by some microradians.
    EXPECT_LT((found.knots[k] - truth.knots[k]).head<3>().norm(), 1e-6);
    EXPECT_LT((found.knots[k] - truth.knots[k]).tail<3>().norm(), 1e-5);
  }
}

}  // namespace
}  // namespace mlic::bias_course_test
