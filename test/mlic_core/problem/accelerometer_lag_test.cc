#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/factors/imu_residual.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/priors.h"
#include "support/spline_through.h"
#include "support/test_motion.h"

namespace mlic::accelerometer_lag_test {
namespace {

constexpr double kRate = 200.0;     // Hz
constexpr double kDuration = 20.0;  // s

// Beside the motion, of which the spline follows a part.
struct Vibration {
  double amplitude = 0.0;  // m/s^2, along all axes
  double frequency = 0.0;  // Hz
};

// The lag (s) that a solve finds in exact samples of a hand-held motion whose accelerometer is late by `lag`,
// with poses as a LiDAR has them. first_sample: s after a knot. pose_noise: of a LiDAR's. turn: rad, of the
// accelerometer against the gyroscope; all that is free in calibrations is so then, else the lag alone.
double FoundLag(double lag, double first_sample, const Vibration& vibration = {}, double pose_noise = 1.0,
                const Eigen::Vector3d& turn = Eigen::Vector3d::Zero()) {
  const test::Motion motion = test::HandHeld();
  constexpr double kSpacing = 0.04;
  const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, kSpacing);
  Dataset dataset;
  dataset.drives.resize(1);
  JointProblem problem;
  problem.dataset = &dataset;
  if (turn.isZero()) {
    problem.imu.lag_sigma = 0.01;
  } else {
    problem.imu = FreedomOf(ImuConfig());
  }
  DriveTerms& terms = problem.drives.emplace_back();
  terms.poses = {{}, 1e-4 * pose_noise, 3e-4 * pose_noise};
  terms.imu_sigma.usual = {Eigen::Vector3d::Constant(3e-3), Eigen::Vector3d::Constant(8e-3)};
  for (double t = first_sample; t < kDuration; t += 1.0 / kRate) {
    ImuSample sample = motion.Sample(t);
    sample.specific_force = ExpMatrix(turn) * motion.Sample(t - lag).specific_force;
    for (int axis = 0; axis < 3; ++axis) {
      sample.specific_force[axis] +=
          vibration.amplitude * std::sin(2.0 * M_PI * vibration.frequency * t + axis);
    }
    dataset.drives[0].imu.push_back(sample);
  }
  for (double t = 0.05; t < kDuration; t += 0.1) terms.poses.T_map_imu.push_back({t, motion.T_map_imu(t)});
  CalibrationState state;
  DriveState drive;
  drive.trajectory = SplineThrough(knots, [&](double t) { return motion.T_map_imu(t); });
  state.drives = {drive};
  EXPECT_TRUE(SolveJointProblem(problem, 20, CancellationToken(), &state).solved);
  return state.accelerometer_lag;
}

// Samples on the knots, a quarter and half of a period behind them.
TEST(AccelerometerLag, DoesNotDependOnWhereSamplesLieBetweenKnots) {
  for (const double first : {0.0, 0.00125, 0.0025}) {
    EXPECT_NEAR(FoundLag(0.0, first), 0.0, 5e-6) << first;
    EXPECT_NEAR(FoundLag(0.006, first), 0.006, 5e-6) << first;
  }
}

// Half of a spacing and more: the specific force is that of other segments than the rates'.
TEST(AccelerometerLag, MayBeLongAgainstTheKnots) {
  EXPECT_NEAR(FoundLag(0.03, 0.0), 0.03, 2e-5);
  EXPECT_NEAR(FoundLag(-0.05, 0.0), -0.05, 5e-5);
}

// Where the spline follows a vibration in part the cost steps as samples pass knots, and rises on the way to
// the lag.
TEST(AccelerometerLag, IsReachedThoughTheCostRises) {
  EXPECT_NEAR(FoundLag(-0.0024, 0.0, {0.03, 12.0}, 30.0), -0.0024, 1.2e-5);
}

// Where the lag lets samples be read earlier, none is left in the trajectory's last segment.
TEST(AccelerometerLag, DoesNotFollowWhatNoSampleShows) {
  const test::Motion motion = test::HandHeld();
  const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, 0.04);
  const double time = knots.End() - 1.5 * knots.spacing;
  // shift: m, of the last control point.
  const auto by_lag = [&](const Eigen::Vector3d& shift) -> Eigen::Vector3d {
    const SplitSpline trajectory = SplineThrough(knots, [&](double t) {
      RigidTransform pose = motion.T_map_imu(t);
      if (t == knots.ControlPointTime(knots.count - 1)) pose.translation += shift;
      return pose;
    });
    ImuResidual::Jacobian jacobian;
    ImuResidual::Evaluate(trajectory, {trajectory, time, 0.0}, ImuCalibration(), kGravity,
                          motion.Sample(time), &jacobian);
    return jacobian.block<1, 3>(ImuResidual::kLag, 3).transpose();
  };
  EXPECT_LT((by_lag({1.0, 0.0, 0.0}) - by_lag(Eigen::Vector3d::Zero())).norm(), 1e-9);
}

// Both turn what an accelerometer reads while the rig turns.
TEST(AccelerometerLag, IsNotTakenForATurnedAccelerometer) {
  EXPECT_NEAR(FoundLag(0.0, 0.0, {}, 1.0, {0.02, -0.01, 0.05}), 0.0, 1e-4);
}

}  // namespace
}  // namespace mlic::accelerometer_lag_test
