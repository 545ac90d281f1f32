#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_sim/imu_simulator.h"

namespace mlic::sim {
namespace {

MotionState AtRest() {
  MotionState state;
  state.velocity.setZero();
  state.acceleration.setZero();
  state.angular_velocity.setZero();
  return state;
}

TEST(ImuSimulator, AtRestZReadsPlusGravity) {
  const ImuSample sample = ImuSimulator(SimulatedImu(), false, Random(1)).Next(0.0, AtRest());
  EXPECT_LT((sample.specific_force - Eigen::Vector3d(0, 0, 9.81)).norm(), 1e-12);
  EXPECT_EQ(sample.angular_velocity.norm(), 0.0);
}

TEST(ImuSimulator, MatricesAndBiasesAct) {
  SimulatedImu imu;
  imu.calibration.gyroscope_matrix << 1.01, 0.02, 0, 0, 0.99, 0, 0.03, 0, 1.0;
  imu.calibration.gyroscope_bias << 0.1, 0.2, 0.3;
  imu.calibration.accelerometer_matrix << 1.1, 0, 0, 0.05, 1, 0, 0, 0, 0.9;
  imu.calibration.accelerometer_bias << -0.1, 0, 0.4;
  MotionState state = AtRest();
  state.angular_velocity << 1, 2, 3;
  state.T_map_imu.rotation = FromRollPitchYaw({M_PI / 2, 0, 0});  // y up
  const ImuSample sample = ImuSimulator(imu, false, Random(1)).Next(0.0, state);
  EXPECT_LT((sample.angular_velocity - Eigen::Vector3d(1.15, 2.18, 3.33)).norm(), 1e-12);
  EXPECT_LT((sample.specific_force - Eigen::Vector3d(-0.1, 9.81, 0.4)).norm(), 1e-12);
}

TEST(ImuSimulator, WhiteNoiseHasTheStatedDensity) {
  SimulatedImu imu;
  imu.rate = 400.0;
  imu.noise = {2e-4, 2e-3};
  ImuSimulator simulator(imu, true, Random(5));
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero(), accelerometer = Eigen::Vector3d::Zero();
  constexpr int kCount = 40000;
  for (int i = 0; i < kCount; ++i) {
    const ImuSample sample = simulator.Next(i / imu.rate, AtRest());
    gyroscope += sample.angular_velocity.cwiseAbs2();
    accelerometer += (sample.specific_force - Eigen::Vector3d(0, 0, 9.81)).cwiseAbs2();
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(std::sqrt(gyroscope[axis] / kCount), 2e-4 * 20.0, 0.02 * 2e-4 * 20.0);
    EXPECT_NEAR(std::sqrt(accelerometer[axis] / kCount), 2e-3 * 20.0, 0.02 * 2e-3 * 20.0);
  }
}

TEST(ImuSimulator, BiasWalkGrowsWithTheRootOfTime) {
  SimulatedImu imu;
  imu.rate = 100.0;
  imu.gyroscope_walk = 1e-3;
  double square = 0.0;
  constexpr int kRuns = 400, kSteps = 900;
  for (int run = 0; run < kRuns; ++run) {
    ImuSimulator simulator(imu, true, Random(run));
    ImuSample sample;
    for (int i = 0; i <= kSteps; ++i) sample = simulator.Next(i / imu.rate, AtRest());
    square += sample.angular_velocity.squaredNorm() / 3.0;
  }
  EXPECT_NEAR(std::sqrt(square / kRuns), 1e-3 * std::sqrt(9.0), 0.15e-3);
}

}  // namespace
}  // namespace mlic::sim
