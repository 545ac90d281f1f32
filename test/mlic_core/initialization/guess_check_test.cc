#include "mlic_core/initialization/guess_check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::guess_check_test {
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
  EXPECT_GT(SigmasOfExchange(GuessAt(front), near_back, GuessAt(back), near_front), kLooksExchanged);
  EXPECT_EQ(SigmasOfExchange(GuessAt(front), near_front, GuessAt(back), near_back), 0.0);
  EXPECT_EQ(SigmasOfExchange(GuessAt(front), near_back, GuessAt(back), near_back), 0.0);
  // Guesses that hardly differ tell nothing.
  const RigidTransform beside = Pose(0.1, 1.05);
  EXPECT_LT(SigmasOfExchange(GuessAt(front), beside, GuessAt(beside), front), kLooksExchanged);
}

// Either of a stereo pair lies within three sigmas of the other's guess: only both together tell.
TEST(GuessCheck, CamerasOfAStereoPairAreExchangedWhereTheirPlacesTurnRound) {
  const RigidTransform left = Pose(0.0, 0.11), right = Pose(0.0, -0.11);
  EXPECT_LT(SigmasFromGuess(GuessAt(left), right), 3.0);
  EXPECT_GT(SigmasOfExchange(GuessAt(left), right, GuessAt(right), left), kLooksExchanged);
  EXPECT_EQ(SigmasOfExchange(GuessAt(left), left, GuessAt(right), right), 0.0);
}

TEST(GuessCheck, GuessesOfTheirOwnSensorsSeldomLookExchanged) {
  Random random(7);
  const int pairs = 200000;
  int exchanged = 0;
  for (int k = 0; k < pairs; ++k) {
    // At this distance errors make them look exchanged most often.
    const RigidTransform a = Pose(0.0, 0.0), b = Pose(0.0, 0.1 * kLooksExchanged / std::sqrt(2.0));
    const auto found = [&](RigidTransform pose) {
      for (int i = 0; i < 3; ++i) pose.translation[i] += 0.1 * random.Normal();
      return pose;
    };
    exchanged += SigmasOfExchange(GuessAt(a), found(a), GuessAt(b), found(b)) > kLooksExchanged;
  }
  EXPECT_GT(exchanged, pairs / 1500);
  EXPECT_LT(exchanged, pairs / 600);
}

}  // namespace
}  // namespace mlic::guess_check_test
