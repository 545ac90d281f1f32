#include "mlic_core/initialization/knot_spacing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"

namespace mlic::knot_spacing_test {
namespace {

// A shaking IMU at the given rate.
std::vector<ImuSample> Shaking(double rate) {
  Random random(5);
  std::vector<ImuSample> samples;
  for (int k = 0; k < 20 * rate; ++k) {
    const double t = k / rate;
    const Eigen::Vector3d shake(std::sin(9.0 * t), std::cos(11.0 * t), std::sin(13.0 * t));
    const Eigen::Vector3d noise(random.Normal(), random.Normal(), random.Normal());
    samples.push_back({t, 0.2 * shake + 1e-3 * noise, shake + 1e-2 * noise});
  }
  return samples;
}

TEST(KnotSpacing, FollowsScansWhereTheImuIsTooSlow) {
  EXPECT_NEAR(ChooseKnotSpacing(Shaking(10.0)).rotation, 0.2, 1e-9);
  EXPECT_NEAR(ChooseKnotSpacing(Shaking(10.0), 0.1).rotation, 0.1, 1e-9);
  EXPECT_NEAR(ChooseKnotSpacing(Shaking(10.0), 0.1).position, 0.1, 1e-9);
  EXPECT_NEAR(ChooseKnotSpacing(Shaking(10.0), 0.01).rotation, 0.04, 1e-9);
  EXPECT_NEAR(ChooseKnotSpacing(Shaking(10.0), 0.5).rotation, 0.2, 1e-9);
  // A fast one says itself how fine it takes.
  EXPECT_EQ(ChooseKnotSpacing(Shaking(200.0), 0.01).rotation, ChooseKnotSpacing(Shaking(200.0)).rotation);
  EXPECT_EQ(ChooseKnotSpacing(Shaking(200.0), 0.01).position, ChooseKnotSpacing(Shaking(200.0)).position);
}

// Vibration far above what splines carry, on rotors at 60 to 95 Hz and one beyond half of the rate, hides
// nothing of the motion.
TEST(KnotSpacing, FollowsTheMotionWhateverVibratesAboveIt) {
  for (const double rate : {200.0, 400.0}) {
    const KnotSpacing quiet = ChooseKnotSpacing(Shaking(rate));
    EXPECT_LT(quiet.rotation, 0.15);
    EXPECT_LT(quiet.position, 0.15);
    std::vector<ImuSample> shaken = Shaking(rate);
    for (ImuSample& sample : shaken) {
      for (const double frequency : {61.0, 78.0, 93.0, 110.0}) {
        const double w = 2.0 * M_PI * frequency;
        const Eigen::Vector3d wave(std::sin(w * sample.time), std::sin(w * sample.time + 1.0),
                                   std::cos(w * sample.time));
        sample.specific_force += 3.0 * wave;
        sample.angular_velocity += 0.1 * wave;
      }
    }
    const KnotSpacing vibrating = ChooseKnotSpacing(shaken);
    EXPECT_LT(std::abs(std::log(vibrating.rotation / quiet.rotation)), 0.25) << rate;
    EXPECT_LT(std::abs(std::log(vibrating.position / quiet.position)), 0.25) << rate;
  }
}

}  // namespace
}  // namespace mlic::knot_spacing_test
