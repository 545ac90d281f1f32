#include "mlic_core/initialization/guess_check.h"

#include <gtest/gtest.h>

#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

ExtrinsicGuess GuessAt(const RigidTransform& pose) {
  ExtrinsicGuess guess;
  guess.T_imu_sensor = pose;
  guess.sigma_rotation.setConstant(0.1);     // rad
  guess.sigma_translation.setConstant(0.1);  // m
  return guess;
}

RigidTransform Pose(double yaw, double x) {
  return {ExpQuaternion(Eigen::Vector3d(0.0, 0.0, yaw)), Eigen::Vector3d(x, 0.0, 0.0)};
}

TEST(GuessCheck, SensorsAreExchangedWhereEachLiesAtTheOthersGuess) {
  const RigidTransform front = Pose(0.0, 1.0), back = Pose(3.0, -1.0);
  const RigidTransform near_front = Pose(0.1, 1.1), near_back = Pose(2.9, -1.1);
  EXPECT_TRUE(AreExchanged(GuessAt(front), near_back, GuessAt(back), near_front));
  EXPECT_FALSE(AreExchanged(GuessAt(front), near_front, GuessAt(back), near_back));
  EXPECT_FALSE(AreExchanged(GuessAt(front), near_back, GuessAt(back), near_back));
  // Guesses that hardly differ tell nothing.
  const RigidTransform beside = Pose(0.1, 1.2);
  EXPECT_FALSE(AreExchanged(GuessAt(front), beside, GuessAt(beside), front));
}

}  // namespace
}  // namespace mlic
