#include "mlic_core/uncertainty/bias_wander.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"

namespace mlic::bias_wander_test {
namespace {

constexpr double kRate = 100.0;
const ImuSigma kSigma{Eigen::Vector3d::Constant(4e-3), Eigen::Vector3d::Constant(0.03)};

// White residuals, with `gyroscope` (rad/s) added to the first axis in the course of the drive.
ImuResiduals Residuals(double duration, double gyroscope, std::uint64_t seed) {
  Random random(seed);
  ImuResiduals residuals;
  for (int k = 0; k < duration * kRate; ++k) {
    const double time = k / kRate;
    residuals.times.push_back(time);
    residuals.values.emplace_back();
    for (int a = 0; a < 6; ++a) {
      residuals.values.back()[a] =
          (a < 3 ? kSigma.gyroscope[a] : kSigma.accelerometer[a - 3]) * random.Normal();
    }
    residuals.values.back()[0] += gyroscope * (time / duration - 0.5);
  }
  return residuals;
}

TEST(BiasWander, WhiteNoiseIsNone) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    found += FindBiasWander(Residuals(60.0, 0.0, seed), {kSigma}).has_value() ? 1 : 0;
  }
  EXPECT_LE(found, 1);
}

TEST(BiasWander, StepsAreThoseOfTheMeans) {
  const std::optional<BiasWander> wander = FindBiasWander(Residuals(60.0, 0.006, 1), {kSigma});
  ASSERT_TRUE(wander.has_value());
  EXPECT_EQ(wander->intervals, 6U);
  EXPECT_NEAR(wander->spacing, 10.0, 0.01);
  EXPECT_NEAR(wander->steps.gyroscope, 0.001 / std::sqrt(3.0), 0.1e-3);  // of one axis of three
  // The accelerometer's do not move: a mean's noise is 1 mm/s^2.
  EXPECT_LT(wander->steps.accelerometer, 1.5e-3);
  EXPECT_GT(wander->steps.accelerometer, 0.0);
}

TEST(BiasWander, LongDrivesHaveAFewKnots) {
  const std::optional<BiasWander> wander = FindBiasWander(Residuals(600.0, 0.006, 1), {kSigma});
  ASSERT_TRUE(wander.has_value());
  EXPECT_EQ(wander->intervals, 20U);
}

TEST(BiasWander, ShortDrivesHaveNone) {
  EXPECT_FALSE(FindBiasWander(Residuals(9.0, 0.02, 1), {kSigma}).has_value());
  EXPECT_FALSE(FindBiasWander({}, {kSigma}).has_value());
}

}  // namespace
}  // namespace mlic::bias_wander_test
