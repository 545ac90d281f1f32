#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "mlic_core/imu/angular_rate_alignment.h"
#include "mlic_core/imu/gravity_lever_arm.h"
#include "support/test_motion.h"

namespace mlic::alignment_test {
namespace {

using test::AddOutliers;
using test::HandHeld;
using test::Noise;
using test::Planar;
using test::Record;

const Noise kOrdinaryNoise{2e-4, 2e-3, 0.01, 0.1 * M_PI / 180.0};

Eigen::Vector3d RotationError(const Eigen::Quaterniond& estimate, const test::Rig& rig) {
  return Log(Eigen::Quaterniond(estimate * rig.T_imu_lidar.rotation.conjugate()));
}

TEST(AngularRateAlignment, RecoversTruthWithoutNoiseForAnyOffset) {
  for (const double offset : {-0.9, -0.31, 0.0, 0.05, 0.9}) {
    test::Rig rig;
    rig.time_offset = offset;
    const auto recording = Record(HandHeld(), rig, {}, 400.0, 30.0, 1);
    const auto result = AlignAngularRates(recording.imu, recording.poses, std::nullopt);
    ASSERT_TRUE(result.valid) << result.failure;
    std::printf("noise-free, offset %5.2f: %.1e s, %.1e rad, bias %.1e\n", offset,
                result.time_offset - offset, RotationError(result.R_imu_lidar, rig).norm(),
                (result.gyroscope_bias - rig.gyroscope_bias).norm());
    EXPECT_NEAR(result.time_offset, offset, 1e-6);
    EXPECT_LT(RotationError(result.R_imu_lidar, rig).norm(), 1e-6);
    EXPECT_LT((result.gyroscope_bias - rig.gyroscope_bias).norm(), 1e-6);
    EXPECT_EQ(result.rotation_directions_shown, 3);
    EXPECT_LT(result.second_peak_ratio, 0.9);
  }
}

TEST(AngularRateAlignment, ErrorsAgreeWithSigmas) {
  test::Rig rig;
  rig.time_offset = 0.123;
  constexpr int kSeeds = 40;
  double offset_squares = 0.0, rotation_squares = 0.0, largest = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto recording = Record(HandHeld(), rig, kOrdinaryNoise, 200.0, 30.0, 100 + seed);
    const auto result = AlignAngularRates(recording.imu, recording.poses, std::nullopt);
    const double offset_error = (result.time_offset - rig.time_offset) / result.time_offset_sigma;
    const Eigen::Vector3d rotation_error = RotationError(result.R_imu_lidar, rig);
    offset_squares += offset_error * offset_error / kSeeds;
    rotation_squares +=
        rotation_error.dot(result.rotation_covariance.inverse() * rotation_error) / (3 * kSeeds);
    largest = std::max(largest, rotation_error.norm());
    if (seed == 0) {
      std::printf("noisy: offset sigma %.2e s, rotation sigma %.2e rad, rms %.2e, correlation %.3f\n",
                  result.time_offset_sigma, std::sqrt(result.rotation_covariance.trace() / 3.0),
                  result.residual_rms, result.peak_correlation);
    }
  }
  std::printf("noisy: normalised squares: offset %.2f, rotation %.2f; largest rotation error %.2e rad\n",
              offset_squares, rotation_squares, largest);
  EXPECT_GT(offset_squares, 0.4);
  EXPECT_LT(offset_squares, 1.8);
  EXPECT_GT(rotation_squares, 0.5);
  EXPECT_LT(rotation_squares, 1.6);
}

TEST(AngularRateAlignment, SurvivesOutliersAndGaps) {
  test::Rig rig;
  rig.time_offset = -0.4;
  auto recording = Record(HandHeld(), rig, kOrdinaryNoise, 200.0, 40.0, 7);
  AddOutliers(0.1, 8, &recording.poses);
  recording.poses.erase(recording.poses.begin() + 100, recording.poses.begin() + 130);
  recording.imu.erase(recording.imu.begin() + 5000, recording.imu.begin() + 5100);
  const auto result = AlignAngularRates(recording.imu, recording.poses, std::nullopt);
  ASSERT_TRUE(result.valid);
  std::printf("outliers: offset %.1e s, rotation %.1e rad, inliers %.3f\n",
              result.time_offset - rig.time_offset, RotationError(result.R_imu_lidar, rig).norm(),
              result.inlier_share);
  EXPECT_NEAR(result.time_offset, rig.time_offset, 5.0 * result.time_offset_sigma);
  const Eigen::Vector3d error = RotationError(result.R_imu_lidar, rig);
  EXPECT_LT(std::sqrt(error.dot(result.rotation_covariance.inverse() * error)), 4.0);
  EXPECT_LT(error.norm(), 1.5e-3);
  EXPECT_GT(result.inlier_share, 0.85);
  EXPECT_LT(result.inlier_share, 0.95);
}

TEST(AngularRateAlignment, ShiftingTheLidarsStampsShiftsTheOffset) {
  auto recording = Record(HandHeld(), {}, kOrdinaryNoise, 200.0, 30.0, 5);
  const auto before = AlignAngularRates(recording.imu, recording.poses, std::nullopt);
  for (TimedPose& pose : recording.poses) pose.time -= 0.25;
  const auto after = AlignAngularRates(recording.imu, recording.poses, std::nullopt);
  EXPECT_NEAR(after.time_offset - before.time_offset, 0.25, 1e-4);
}

TEST(AngularRateAlignment, SegmentsShowTheDriftOfTheClock) {
  constexpr double kRate = 200.0, kLength = 40.0;  // Hz, s
  test::Rig rig;
  rig.time_offset = 0.07;
  for (const double drift : {0.0, 4e-4, -2e-3}) {
    for (const int seed : {1, 2, 3}) {
      auto recording = Record(HandHeld(), rig, kOrdinaryNoise, kRate, kLength, seed);
      for (TimedPose& pose : recording.poses) {
        pose.time = (pose.time + drift * 0.5 * kLength) / (1.0 + drift);
      }
      const auto result = AlignAngularRates(recording.imu, recording.poses, std::nullopt);
      ASSERT_TRUE(result.valid) << result.failure;
      std::printf("drift %6.0f ppm: %7.1f, sigma %.1f\n", 1e6 * drift, 1e6 * result.clock_drift,
                  1e6 * result.clock_drift_sigma);
      EXPECT_LT(result.clock_drift_sigma, 1e-4);
      // A large drift hides a part of itself: offsets far from the mean one count for less.
      EXPECT_LT(std::abs(result.clock_drift - drift), 4.0 * result.clock_drift_sigma + 0.1 * std::abs(drift));
    }
  }
}

TEST(AngularRateAlignment, TurningAboutOneAxisIsFlaggedAndTheGuessUsed) {
  test::Rig rig;
  rig.time_offset = 0.35;
  const auto recording = Record(Planar(), rig, kOrdinaryNoise, 200.0, 60.0, 11);
  const auto without = AlignAngularRates(recording.imu, recording.poses, std::nullopt);
  ASSERT_TRUE(without.valid);
  EXPECT_EQ(without.rotation_directions_shown, 2);
  EXPECT_GT(std::abs(without.information_directions(2, 0)), 0.999);
  EXPECT_NEAR(without.time_offset, rig.time_offset, 5.0 * without.time_offset_sigma);

  RotationGuess guess;
  const Eigen::Vector3d guess_error(0.05, -0.04, 0.06);
  guess.R_imu_lidar = ExpQuaternion(guess_error) * rig.T_imu_lidar.rotation;
  const auto with = AlignAngularRates(recording.imu, recording.poses, guess);
  ASSERT_TRUE(with.valid);
  const Eigen::Vector3d error = RotationError(with.R_imu_lidar, rig);
  std::printf("planar: offset %.1e (sigma %.1e), rotation %.1e %.1e %.1e, sigma z %.3f\n",
              with.time_offset - rig.time_offset, with.time_offset_sigma, error.x(), error.y(), error.z(),
              std::sqrt(with.rotation_covariance(2, 2)));
  EXPECT_LT(error.head<2>().norm(), 2e-3);
  EXPECT_NEAR(error.z(), guess_error.z(), 0.03);
  EXPECT_GT(std::sqrt(with.rotation_covariance(2, 2)), 0.06);
  EXPECT_EQ(with.rotation_directions_shown, 2);
}

TEST(AngularRateAlignment, WithoutOverlapItSaysSo) {
  auto recording = Record(HandHeld(), {}, {}, 200.0, 10.0, 5);
  for (TimedPose& pose : recording.poses) pose.time += 100.0;
  const auto result = AlignAngularRates(recording.imu, recording.poses, std::nullopt);
  EXPECT_FALSE(result.valid);
  EXPECT_FALSE(result.failure.empty());
}

TEST(AngularRateAlignment, ANavigationSystemAt10HzWillDo) {
  test::Rig rig;
  rig.time_offset = 0.0687;
  const Noise noise{1e-4, 1e-3, 0.01, 3e-4};
  const auto recording = Record(Planar(), rig, noise, 10.0, 60.0, 2);
  RotationGuess guess;
  guess.R_imu_lidar = ExpQuaternion({0.03, 0.05, 0.0}) * rig.T_imu_lidar.rotation;
  const auto result = AlignAngularRates(recording.imu, recording.poses, guess);
  ASSERT_TRUE(result.valid);
  std::printf("10 Hz: offset %.1e s (sigma %.1e)\n", result.time_offset - rig.time_offset,
              result.time_offset_sigma);
  EXPECT_NEAR(result.time_offset, rig.time_offset, 2e-3);
  EXPECT_LT(RotationError(result.R_imu_lidar, rig).head<2>().norm(), 2e-3);
}

TEST(AngularRateAlignment, RestAndConstantTurningShowNothing) {
  test::Motion circle;
  circle.rpy[2].slope = 0.4;
  for (const auto& motion : {test::Motion(), circle}) {
    const auto recording = Record(motion, {}, kOrdinaryNoise, 200.0, 30.0, 4);
    const auto result = AlignAngularRates(recording.imu, recording.poses, std::nullopt);
    if (!result.valid) continue;
    EXPECT_GT(result.time_offset_sigma, 1.0);
    EXPECT_LT(result.rotation_directions_shown, 3);
    EXPECT_LT(result.peak_correlation, 0.3);
  }
}

TEST(GravityLeverArm, RecoversTruthWithoutNoise) {
  test::Rig rig;
  rig.time_offset = 0.05;
  const auto recording = Record(HandHeld(), rig, {}, 400.0, 30.0, 1);
  const auto result = SolveGravityLeverArm(recording.imu, recording.poses, rig.T_imu_lidar.rotation,
                                           rig.time_offset, rig.gyroscope_bias, std::nullopt);
  ASSERT_TRUE(result.valid);
  const double lever = (result.p_imu_lidar - rig.T_imu_lidar.translation).norm();
  std::printf("noise-free: lever arm %.1e m, gravity %.1e m/s^2, bias %.1e m/s^2, rms %.1e m\n", lever,
              (result.gravity - recording.gravity).norm(),
              (result.accelerometer_bias - rig.accelerometer_bias).norm(), result.residual_rms);
  EXPECT_LT(lever, 1e-5);
  EXPECT_LT((result.gravity - recording.gravity).norm(), 1e-5);
  EXPECT_LT((result.accelerometer_bias - rig.accelerometer_bias).norm(), 1e-5);
}

TEST(GravityLeverArm, ErrorsAgreeWithSigmas) {
  const test::Rig rig;
  constexpr int kSeeds = 40;
  double lever_squares = 0.0, bias_squares = 0.0, largest = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto recording = Record(HandHeld(), rig, kOrdinaryNoise, 200.0, 30.0, 200 + seed);
    const auto result = SolveGravityLeverArm(recording.imu, recording.poses, rig.T_imu_lidar.rotation, 0.0,
                                             rig.gyroscope_bias, std::nullopt);
    const Eigen::Vector3d lever = result.p_imu_lidar - rig.T_imu_lidar.translation;
    const Eigen::Vector3d bias = result.accelerometer_bias - rig.accelerometer_bias;
    lever_squares += lever.dot(result.lever_arm_covariance.inverse() * lever) / (3 * kSeeds);
    bias_squares += bias.dot(result.accelerometer_bias_covariance.inverse() * bias) / (3 * kSeeds);
    largest = std::max(largest, lever.norm());
    if (seed == 0) {
      std::printf("noisy: lever arm sigma %.2e m, gravity sigma %.2e rad, rms %.2e m\n",
                  std::sqrt(result.lever_arm_covariance.trace() / 3.0), result.gravity_direction_sigma,
                  result.residual_rms);
    }
  }
  std::printf("noisy: normalised squares: lever arm %.2f, bias %.2f; largest lever arm error %.2e m\n",
              lever_squares, bias_squares, largest);
  EXPECT_GT(lever_squares, 0.5);
  EXPECT_LT(lever_squares, 1.6);
  EXPECT_GT(bias_squares, 0.4);
  EXPECT_LT(bias_squares, 1.8);
}

TEST(GravityLeverArm, SurvivesOutliers) {
  const test::Rig rig;
  auto recording = Record(HandHeld(), rig, kOrdinaryNoise, 200.0, 40.0, 7);
  AddOutliers(0.1, 8, &recording.poses);
  const auto result = SolveGravityLeverArm(recording.imu, recording.poses, rig.T_imu_lidar.rotation, 0.0,
                                           rig.gyroscope_bias, std::nullopt);
  const double error = (result.p_imu_lidar - rig.T_imu_lidar.translation).norm();
  std::printf("outliers: lever arm %.1e m, inliers %.3f\n", error, result.inlier_share);
  EXPECT_LT(error, 0.01);
  EXPECT_GT(result.inlier_share, 0.8);
}

TEST(GravityLeverArm, OnAPlaneHeightIsLeftToTheGuess) {
  const test::Rig rig;
  const auto recording = Record(Planar(), rig, kOrdinaryNoise, 200.0, 60.0, 3);
  LeverArmGuess guess;
  guess.p_imu_lidar = rig.T_imu_lidar.translation + Eigen::Vector3d(0.06, -0.05, 0.08);
  const auto result = SolveGravityLeverArm(recording.imu, recording.poses, rig.T_imu_lidar.rotation, 0.0,
                                           rig.gyroscope_bias, guess);
  const Eigen::Vector3d error = result.p_imu_lidar - rig.T_imu_lidar.translation;
  std::printf("planar: lever arm error %.4f %.4f %.4f, sigmas %.4f %.4f %.4f m\n", error.x(), error.y(),
              error.z(), std::sqrt(result.lever_arm_covariance(0, 0)),
              std::sqrt(result.lever_arm_covariance(1, 1)), std::sqrt(result.lever_arm_covariance(2, 2)));
  EXPECT_LT(result.lever_arm_information(2, 2), 1.0 / (0.5 * 0.5));
  EXPECT_NEAR(std::sqrt(result.lever_arm_covariance(2, 2)), 0.1, 0.01);
  EXPECT_NEAR(error.z(), 0.08, 0.03);
  EXPECT_LT(std::abs(error.x()), 4.0 * std::sqrt(result.lever_arm_covariance(0, 0)));
  EXPECT_LT(std::abs(error.y()), 4.0 * std::sqrt(result.lever_arm_covariance(1, 1)));
  EXPECT_LT(std::sqrt(result.lever_arm_covariance(0, 0)), 0.09);
}

TEST(GravityLeverArm, OnAPlaneAccelerationsShowTheHeading) {
  const test::Rig rig;
  const auto recording = Record(Planar(), rig, kOrdinaryNoise, 200.0, 60.0, 5);
  LeverArmGuess guess;
  guess.p_imu_lidar = rig.T_imu_lidar.translation + Eigen::Vector3d(0.06, -0.05, 0.08);
  const double heading_error = 0.3;
  const Eigen::Quaterniond R_start = ExpQuaternion({0.0, 0.0, heading_error}) * rig.T_imu_lidar.rotation;
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1e-8, 1e-8, 0.1).asDiagonal();
  const auto result = SolveGravityLeverArm(recording.imu, recording.poses, R_start, 0.0, rig.gyroscope_bias,
                                           guess, covariance);
  const double error = RotationError(result.R_imu_lidar, rig).z();
  std::printf("planar: heading from accelerations %.1e rad, sigma %.1e\n", error,
              std::sqrt(result.rotation_covariance(2, 2)));
  EXPECT_LT(std::abs(error), 4.0 * std::sqrt(result.rotation_covariance(2, 2)));
  EXPECT_LT(std::abs(error), 0.02);
}

}  // namespace
}  // namespace mlic::alignment_test
