#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mlic_core/geometry/so3.h"
#include "mlic_sim/imu_simulator.h"

namespace mlic::sim::imu_test {
namespace {

MotionState AtRest(double = 0.0) {
  MotionState state;
  state.velocity.setZero();
  state.acceleration.setZero();
  state.angular_velocity.setZero();
  return state;
}

TEST(ImuSimulator, AtRestZReadsPlusGravity) {
  const ImuSample sample = ImuSimulator(SimulatedImu(), false, Random(1)).Next(0.0, AtRest);
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
  const ImuSample sample = ImuSimulator(imu, false, Random(1)).Next(0.0, [&](double) { return state; });
  EXPECT_LT((sample.angular_velocity - Eigen::Vector3d(1.15, 2.18, 3.33)).norm(), 1e-12);
  EXPECT_LT((sample.specific_force - Eigen::Vector3d(-0.1, 9.81, 0.4)).norm(), 1e-12);
}

TEST(ImuSimulator, BiasesSettleAsItWarmsUp) {
  SimulatedImu imu;
  imu.rate = 100.0;
  imu.warm_up = {{0.01, 0.0, -0.02}, {0.0, 0.3, 0.0}, 20.0};
  ImuSimulator simulator(imu, false, Random(1));
  EXPECT_EQ(simulator.Next(0.0, AtRest).angular_velocity.norm(), 0.0);
  const ImuSample warm = simulator.Next(20.0, AtRest);
  const double share = 1.0 - std::exp(-1.0);
  EXPECT_LT((warm.angular_velocity - share * Eigen::Vector3d(0.01, 0.0, -0.02)).norm(), 1e-12);
  EXPECT_LT((warm.specific_force - Eigen::Vector3d(0.0, share * 0.3, 9.81)).norm(), 1e-12);
}

TEST(ImuSimulator, WhiteNoiseHasTheStatedDensity) {
  SimulatedImu imu;
  imu.rate = 400.0;
  imu.noise = {2e-4, 2e-3};
  ImuSimulator simulator(imu, true, Random(5));
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero(), accelerometer = Eigen::Vector3d::Zero();
  constexpr int kCount = 40000;
  for (int i = 0; i < kCount; ++i) {
    const ImuSample sample = simulator.Next(i / imu.rate, AtRest);
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
    for (int i = 0; i <= kSteps; ++i) sample = simulator.Next(i / imu.rate, AtRest);
    square += sample.angular_velocity.squaredNorm() / 3.0;
  }
  EXPECT_NEAR(std::sqrt(square / kRuns), 1e-3 * std::sqrt(9.0), 0.15e-3);
}

// Turns to and fro about x, and is pushed along y, with amplitude one.
MotionState Swinging(double time, double frequency) {
  MotionState state = AtRest();
  const double w = 2.0 * M_PI * frequency;
  state.angular_velocity.x() = std::sin(w * time);
  state.acceleration.y() = std::sin(w * time);
  return state;
}

// Amplitude and delay (s) of what an IMU reads of a swing: gyroscope's x and accelerometer's y.
struct Answer {
  double amplitude, delay;
};
Answer AnswerTo(const SimulatedImu& imu, double frequency, bool gyroscope) {
  ImuSimulator simulator(imu, false, Random(1));
  const double w = 2.0 * M_PI * frequency;
  double in_phase = 0.0, out_of_phase = 0.0;
  constexpr int kCount = 2000;  // whole periods of 1, 10 and 40 Hz at 200 Hz
  for (int i = 0; i < kCount; ++i) {
    const double time = i / imu.rate;
    const ImuSample sample = simulator.Next(time, [&](double t) { return Swinging(t, frequency); });
    const double value = gyroscope ? sample.angular_velocity.x() : sample.specific_force.y();
    in_phase += 2.0 / kCount * value * std::sin(w * time);
    out_of_phase += 2.0 / kCount * value * std::cos(w * time);
  }
  return {std::hypot(in_phase, out_of_phase), -std::atan2(out_of_phase, in_phase) / w};
}

TEST(ImuSimulator, LowPassDelaysSlowMotionAndTakesFastMotionAway) {
  SimulatedImu imu;
  imu.gyroscope_low_pass = 0.1;
  imu.accelerometer_low_pass = 0.2;
  for (const bool gyroscope : {true, false}) {
    const double low_pass = gyroscope ? 0.1 : 0.2, cut_off = low_pass * imu.rate;
    const Answer slow = AnswerTo(imu, 1.0, gyroscope);
    EXPECT_NEAR(slow.amplitude, 1.0, 1e-4);
    EXPECT_NEAR(slow.delay, GroupDelay(low_pass, imu.rate), 2e-5);
    for (const double frequency : {10.0, 40.0}) {
      // |H|^2 = 1 / (1 + (f / f_c)^4)
      const double expected = 1.0 / std::sqrt(1.0 + std::pow(frequency / cut_off, 4));
      EXPECT_NEAR(AnswerTo(imu, frequency, gyroscope).amplitude, expected, 5e-3) << frequency;
    }
  }
  imu.accelerometer_low_pass = 0.0;
  EXPECT_NEAR(AnswerTo(imu, 40.0, false).amplitude, 1.0, 1e-12);
}

// Below the cut-off the noise keeps its density; samples scatter less, and third differences hardly at all.
TEST(ImuSimulator, LowPassColoursTheNoise) {
  SimulatedImu imu;
  imu.noise = {1e-3, 1e-2};
  imu.gyroscope_low_pass = 0.1;
  ImuSimulator simulator(imu, true, Random(2));
  constexpr int kBlock = 200, kBlocks = 400;
  double of_means = 0.0, of_samples = 0.0;
  for (int b = 0; b < kBlocks; ++b) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (int i = 0; i < kBlock; ++i) {
      const Eigen::Vector3d w = simulator.Next((b * kBlock + i) / imu.rate, AtRest).angular_velocity;
      mean += w / kBlock;
      of_samples += w.squaredNorm() / 3.0 / (kBlock * kBlocks);
    }
    of_means += mean.squaredNorm() / 3.0 / kBlocks;
  }
  EXPECT_NEAR(std::sqrt(of_means), 1e-3, 0.06e-3);  // of 1 s
  // White noise through a second-order Butterworth: its variance is density^2 * f_c * pi / sqrt(2).
  EXPECT_NEAR(std::sqrt(of_samples), 1e-3 * std::sqrt(20.0 * M_PI / std::sqrt(2.0)), 0.1e-3);
}

TEST(ImuSimulator, VibrationHasItsAmplitudeAndFrequency) {
  SimulatedImu imu;
  imu.vibration = {{50.0, 3.0, 0.2}};
  ImuSimulator simulator(imu, false, Random(4));
  std::vector<ImuSample> samples;
  for (int i = 0; i < 400; ++i) samples.push_back(simulator.Next(i / imu.rate, AtRest));
  double force = 0.0, rate = 0.0;
  for (const ImuSample& sample : samples) {
    force += (sample.specific_force - Eigen::Vector3d(0, 0, 9.81)).squaredNorm() / 400.0;
    rate += sample.angular_velocity.squaredNorm() / 400.0;
  }
  EXPECT_NEAR(std::sqrt(2.0 * force), 3.0, 1e-9);
  EXPECT_NEAR(std::sqrt(2.0 * rate), 0.2, 1e-10);
  for (int i = 4; i < 400; ++i) {
    EXPECT_LT((samples[i].specific_force - samples[i - 4].specific_force).norm(), 1e-9);
  }
}

TEST(ImuSimulator, GravityIsTheOneOfThePlace) {
  SimulatedImu imu;
  imu.gravity = 9.79;
  const ImuSample sample = ImuSimulator(imu, false, Random(1)).Next(0.0, AtRest);
  EXPECT_LT((sample.specific_force - Eigen::Vector3d(0, 0, 9.79)).norm(), 1e-12);
}

}  // namespace
}  // namespace mlic::sim::imu_test
