#include "mlic_core/evaluation/methods/camera_lever_arm.h"

#include <gtest/gtest.h>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/pose_fit.h"
#include "support/test_motion.h"

namespace mlic::camera_lever_arm_test {
namespace {

const RigidTransform kTruth{FromRollPitchYaw({-1.5, 0.1, -1.4}), {0.31, -0.12, 0.22}};
constexpr double kOffset = 0.013;  // s
constexpr double kDuration = 30.0;

SplitSpline TrajectoryOf(const test::Motion& motion) {
  std::vector<TimedPose> poses;
  for (int k = 0; k <= 500 * kDuration; ++k) poses.push_back({0.002 * k, motion.T_map_imu(0.002 * k)});
  return SplineThrough(poses, KnotSpacing{0.002, 0.002});
}

// As images a third of a second apart show them, the direction `noise` rad off; every `bad`-th anywhere.
std::vector<VisualMotion> MotionsOf(const SplitSpline& T_map_imu, double noise, int bad) {
  Random random(3);
  std::vector<VisualMotion> motions;
  for (double t = 0.1; t + 0.4 < kDuration; t += 0.2) {
    const RigidTransform a = T_map_imu.Pose(t + kOffset) * kTruth;
    const RigidTransform b = T_map_imu.Pose(t + 0.33 + kOffset) * kTruth;
    VisualMotion motion{0, t, t + 0.33, (a.rotation.conjugate() * b.rotation).toRotationMatrix(), {}};
    motion.direction = b.rotation.conjugate() * (b.translation - a.translation).normalized();
    if (bad > 0 && motions.size() % bad == 0)
      motion.direction = Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
    motion.direction =
        ExpQuaternion(noise * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal())) *
        motion.direction;
    motions.push_back(motion);
  }
  return motions;
}

ExtrinsicGuess GuessOff(const Eigen::Vector3d& by) {
  ExtrinsicGuess guess;
  guess.T_imu_sensor = kTruth;
  guess.T_imu_sensor.translation += by;
  return guess;
}

TEST(CameraLeverArm, IsFoundWithoutAGuess) {
  const SplitSpline trajectory = TrajectoryOf(test::HandHeld());
  const auto found =
      CameraLeverArm(MotionsOf(trajectory, 0.0, 0), {&trajectory}, kTruth.rotation, kOffset, std::nullopt);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - kTruth.translation).norm(), 1e-6);
}

TEST(CameraLeverArm, BearsNoiseAndMotionsThatAreWrong) {
  const SplitSpline trajectory = TrajectoryOf(test::HandHeld());
  const auto found =
      CameraLeverArm(MotionsOf(trajectory, 0.01, 5), {&trajectory}, kTruth.rotation, kOffset, std::nullopt);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - kTruth.translation).norm(), 0.02);
}

// Turns about the vertical alone do not show the height: the guess has it.
TEST(CameraLeverArm, LeavesTheGuessWhatAPlaneDoesNotShow) {
  const SplitSpline trajectory = TrajectoryOf(test::Planar());
  const auto found = CameraLeverArm(MotionsOf(trajectory, 1e-3, 0), {&trajectory}, kTruth.rotation, kOffset,
                                    GuessOff({0.05, -0.06, 0.07}));
  ASSERT_TRUE(found);
  EXPECT_LT((*found - kTruth.translation).head<2>().norm(), 0.01);
  EXPECT_NEAR(found->z() - kTruth.translation.z(), 0.07, 0.01);
}

TEST(CameraLeverArm, NeedsMotion) {
  const SplitSpline trajectory = TrajectoryOf(test::HandHeld());
  std::vector<VisualMotion> motions = MotionsOf(trajectory, 0.0, 0);
  for (VisualMotion& motion : motions) motion.direction.setZero();
  EXPECT_FALSE(CameraLeverArm(motions, {&trajectory}, kTruth.rotation, kOffset, std::nullopt));
}

}  // namespace
}  // namespace mlic::camera_lever_arm_test
