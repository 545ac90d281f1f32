#include "mlic_core/imu/hand_eye.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "support/test_motion.h"

namespace mlic::hand_eye_test {
namespace {

std::vector<RelativeMotion> Motions(const test::Motion& motion, const test::Rig& rig, double noise_rotation,
                                    double noise_translation, std::uint64_t seed) {
  Random random(seed);
  std::vector<RelativeMotion> motions;
  for (double t = 0.0; t < 60.0; t += 0.5) {
    RelativeMotion m;
    m.imu = motion.T_map_imu(t).Inverse() * motion.T_map_imu(t + 0.5);
    m.lidar = rig.T_imu_lidar.Inverse() * m.imu * rig.T_imu_lidar;
    m.lidar.rotation = m.lidar.rotation * ExpQuaternion(noise_rotation * test::NormalVector(&random));
    m.lidar.translation += noise_translation * test::NormalVector(&random);
    motions.push_back(m);
  }
  return motions;
}

Eigen::Matrix<double, 6, 1> Error(const RigidTransform& estimate, const test::Rig& rig) {
  Eigen::Matrix<double, 6, 1> error;
  error << Log(Eigen::Quaterniond(estimate.rotation * rig.T_imu_lidar.rotation.conjugate())),
      estimate.translation - rig.T_imu_lidar.translation;
  return error;
}

TEST(HandEye, RecoversTruthWithoutNoise) {
  const test::Rig rig;
  const auto result = SolveHandEye(Motions(test::HandHeld(), rig, 0.0, 0.0, 1), std::nullopt);
  ASSERT_TRUE(result.valid);
  EXPECT_LT(Error(result.T_imu_lidar, rig).norm(), 1e-9);
  EXPECT_EQ(result.rotation_directions_shown, 3);
}

TEST(HandEye, SwappingTheSensorsInvertsTheResult) {
  const test::Rig rig;
  auto motions = Motions(test::HandHeld(), rig, 0.0, 0.0, 1);
  for (RelativeMotion& m : motions) std::swap(m.imu, m.lidar);
  const auto result = SolveHandEye(motions, std::nullopt);
  EXPECT_LT(Error(result.T_imu_lidar.Inverse(), rig).norm(), 1e-9);
}

TEST(HandEye, ErrorsAgreeWithSigmas) {
  const test::Rig rig;
  constexpr int kSeeds = 60;
  double squares = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto result = SolveHandEye(Motions(test::HandHeld(), rig, 2e-3, 1e-2, 50 + seed), std::nullopt);
    const auto error = Error(result.T_imu_lidar, rig);
    squares += error.dot(result.covariance.inverse() * error) / (6 * kSeeds);
  }
  std::printf("hand-eye: normalised square %.2f\n", squares);
  EXPECT_GT(squares, 0.6);
  EXPECT_LT(squares, 1.5);
}

TEST(HandEye, SurvivesOutliers) {
  const test::Rig rig;
  auto motions = Motions(test::HandHeld(), rig, 2e-3, 1e-2, 2);
  Random random(3);
  for (std::size_t i = 0; i < motions.size(); i += 5) {
    motions[i].lidar.rotation = motions[i].lidar.rotation * ExpQuaternion(0.5 * test::NormalVector(&random));
    motions[i].lidar.translation += test::NormalVector(&random);
  }
  const auto result = SolveHandEye(motions, std::nullopt);
  const auto error = Error(result.T_imu_lidar, rig);
  std::printf("hand-eye with outliers: %.1e rad, %.1e m, inliers %.2f\n", error.head<3>().norm(),
              error.tail<3>().norm(), result.inlier_share);
  EXPECT_LT(std::sqrt(error.dot(result.covariance.inverse() * error)), 4.5);
  EXPECT_NEAR(result.inlier_share, 0.8, 0.05);
}

TEST(HandEye, OnAPlaneTheTranslationsShowTheHeadingAndHeightIsLeftToTheGuess) {
  const test::Rig rig;
  const auto motions = Motions(test::Planar(), rig, 5e-4, 5e-3, 2);
  const auto without = SolveHandEye(motions, std::nullopt);
  EXPECT_EQ(without.rotation_directions_shown, 2);
  EXPECT_LT(Error(without.T_imu_lidar, rig).head<3>().norm(), 0.01);
  EXPECT_LT((Error(without.T_imu_lidar, rig).segment<2>(3)).norm(), 0.05);
  EXPECT_GT(std::sqrt(without.covariance(5, 5)), 5.0);
  EXPECT_LT(without.information(5, 5), 1e-6);

  ExtrinsicGuess guess;
  guess.T_imu_sensor = {ExpQuaternion({0.05, 0.04, -0.05}) * rig.T_imu_lidar.rotation,
                        rig.T_imu_lidar.translation + Eigen::Vector3d(0.1, 0.05, -0.07)};
  const auto with = SolveHandEye(motions, guess);
  const auto error = Error(with.T_imu_lidar, rig);
  EXPECT_LT(error.head<3>().norm(), 0.01);
  EXPECT_LT(error.segment<2>(3).norm(), 0.03);
  EXPECT_NEAR(error[5], -0.07, 1e-6);
  EXPECT_NEAR(std::sqrt(with.covariance(5, 5)), 0.1, 1e-3);
}

TEST(RelativeMotions, PairPosesAcrossTheClockOffset) {
  // A constant-rate turn, which the spline represents exactly.
  const UniformKnots knots = UniformKnots::Covering(0.0, 10.0, 0.5);
  const Eigen::Vector3d rate(0.1, -0.2, 0.3), velocity(1.0, 0.5, -0.2);
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> positions;
  for (int j = 0; j < knots.count; ++j) {
    rotations.push_back(ExpQuaternion(rate * knots.ControlPointTime(j)));
    positions.push_back(velocity * knots.ControlPointTime(j));
  }
  const SplitSpline spline{So3Spline(knots, rotations), PositionSpline(knots, positions)};
  const test::Rig rig;
  std::vector<TimedPose> poses;
  for (double t = -0.5; t < 12.0; t += 0.1) {
    const double imu_time = t + 0.3;
    poses.push_back(
        {t, RigidTransform{ExpQuaternion(rate * imu_time), velocity * imu_time} * rig.T_imu_lidar});
  }
  const auto motions = RelativeMotions(spline, poses, 0.3, 0.5);
  EXPECT_NEAR(static_cast<double>(motions.size()), 95.0, 2.0);
  for (const RelativeMotion& m : motions) {
    const RigidTransform predicted = rig.T_imu_lidar.Inverse() * m.imu * rig.T_imu_lidar;
    EXPECT_LT(AngleBetween(predicted.rotation, m.lidar.rotation), 1e-9);
    EXPECT_LT((predicted.translation - m.lidar.translation).norm(), 1e-9);
    EXPECT_NEAR(Log(m.imu.rotation).norm(), 0.5 * rate.norm(), 1e-9);
  }
}

TEST(HandEye, TooFewMotionsAreAFailureThatSaysSo) {
  const auto result = SolveHandEye({}, std::nullopt);
  EXPECT_FALSE(result.valid);
  EXPECT_FALSE(result.failure.empty());
}

}  // namespace
}  // namespace mlic::hand_eye_test
