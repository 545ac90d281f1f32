#include "mlic_core/imu/vibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_core/imu/least_noise.h"

namespace mlic::vibration_test {
namespace {

constexpr double kRate = 200.0;
constexpr double kNoise = 0.01;

double SlowForce(double time) { return 9.8 + 0.3 * time + 2.0 * std::sin(2.0 * M_PI * 5.0 * time); }

// 20 s of slow motion with noise, and a line of `line` m/s^2 along z; lost: share of the samples.
std::vector<ImuSample> Shaken(double line, double lost = 0.0, double frequency = 73.0) {
  Random random(5);
  std::vector<ImuSample> samples;
  for (int k = 0; k < 4000; ++k) {
    ImuSample sample;
    sample.time = k / kRate;
    for (int axis = 0; axis < 3; ++axis) {
      sample.angular_velocity[axis] = std::sin(sample.time + axis) + 0.1 * kNoise * random.Normal();
      sample.specific_force[axis] = kNoise * random.Normal();
    }
    sample.specific_force.z() +=
        SlowForce(sample.time) + line * std::sin(2.0 * M_PI * frequency * sample.time + 0.4);
    if (random.Uniform() >= lost) samples.push_back(sample);
  }
  return samples;
}

double RmsError(const std::vector<ImuSample>& samples) {
  double squares = 0.0;
  for (const ImuSample& sample : samples) {
    squares += std::pow(sample.specific_force.z() - SlowForce(sample.time), 2);
  }
  return std::sqrt(squares / static_cast<double>(samples.size()));
}

double LargestError(const std::vector<ImuSample>& samples) {
  double largest = 0.0;
  for (const ImuSample& sample : samples) {
    largest = std::max(largest, std::abs(sample.specific_force.z() - SlowForce(sample.time)));
  }
  return largest;
}

double LongestPeriod(const std::vector<ImuSample>& samples) {
  double longest = 0.0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    longest = std::max(longest, samples[k].time - samples[k - 1].time);
  }
  return longest;
}

TEST(Vibration, NoiseAloneStaysAsItIs) {
  EXPECT_FALSE(WithoutVibration(Shaken(0.0)));
  EXPECT_FALSE(WithoutVibration(Shaken(0.5 * kNoise)));
  EXPECT_FALSE(WithoutVibration({}));
  std::vector<ImuSample> exact;  // but for rounding
  for (int k = 0; k < 4000; ++k) exact.push_back({k / kRate, {0.1, 0.0, 0.0}, {0.0, 0.0, 9.81}});
  EXPECT_FALSE(WithoutVibration(exact));
}

TEST(Vibration, ALineAboveTheBandGoesAndTheMotionStays) {
  for (const double frequency : {22.0, 27.0, 34.0, 45.0, 73.0, 91.0}) {
    const std::optional<FilteredImu> filtered = WithoutVibration(Shaken(3.0, 0.0, frequency));
    ASSERT_TRUE(filtered) << frequency;
    EXPECT_EQ(filtered->above, frequency < 37.5 ? 18.75 : 37.5);
    EXPECT_NEAR(filtered->specific_force, 3.0 / std::sqrt(2.0), 0.05) << frequency;
    EXPECT_NEAR(static_cast<double>(filtered->samples.size()), 20.0 * 2.0 * filtered->above, 30.0);
    EXPECT_LT(LargestError(filtered->samples), 5.0 * kNoise) << frequency;
  }
}

// 20 s of slow turning at 200 Hz with a line of `line` rad/s about y, forces as they are.
std::vector<ImuSample> Turning(double line, double frequency) {
  std::vector<ImuSample> samples = Shaken(0.0);
  for (ImuSample& sample : samples) {
    sample.angular_velocity.y() += line * std::sin(2.0 * M_PI * frequency * sample.time);
  }
  return samples;
}

TEST(Vibration, TurningThatNoSplineFollowsGoesFromTheRates) {
  for (const double frequency : {14.0, 16.0, 18.0}) {
    const std::optional<FilteredImu> filtered = WithoutVibration(Turning(0.05, frequency));
    ASSERT_TRUE(filtered) << frequency;
    EXPECT_EQ(filtered->above, 37.5);
    EXPECT_EQ(filtered->turns_above, 12.5);
    EXPECT_NEAR(filtered->fast_turns, 0.05 / std::sqrt(2.0), 0.002) << frequency;
    for (const ImuSample& sample : filtered->samples) {
      // Ends are smoothed over less.
      if (sample.time < 0.4 || sample.time > 19.6) continue;
      EXPECT_NEAR(sample.angular_velocity.y(), std::sin(sample.time + 1.0), 0.003) << sample.time;
    }
    EXPECT_LT(LargestError(filtered->samples), 5.0 * kNoise) << frequency;
  }
}

TEST(Vibration, TurningThatSplinesFollowStays) {
  EXPECT_FALSE(WithoutVibration(Turning(0.05, 8.0)));
  // 0.7 of the density that the worst gyroscope has over the octave from 12.5 Hz
  EXPECT_FALSE(WithoutVibration(Turning(0.7 * kWorstGyroscope * std::sqrt(2.0 * 25.0), 18.0)));
}

// A gyroscope of the worst usual density, and a worse one: noise is as dense beyond the octave, turning is
// not.
TEST(Vibration, ANoisyGyroscopeDoesNotTurn) {
  for (const double density : {kWorstGyroscope, 3.0 * kWorstGyroscope}) {
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
      Random random(seed);
      std::vector<ImuSample> samples = Shaken(0.0);
      for (ImuSample& sample : samples) {
        for (int axis = 0; axis < 3; ++axis) {
          sample.angular_velocity[axis] += density * std::sqrt(kRate) * random.Normal();
        }
      }
      EXPECT_FALSE(WithoutVibration(samples)) << density << ", seed " << seed;
    }
  }
}

TEST(Vibration, BehindTheLowerFilterTurningGoesFromEarlierOn) {
  std::vector<ImuSample> samples = Turning(0.05, 11.0);
  for (ImuSample& sample : samples) sample.specific_force.x() += std::sin(2.0 * M_PI * 27.0 * sample.time);
  const std::optional<FilteredImu> filtered = WithoutVibration(samples);
  ASSERT_TRUE(filtered);
  EXPECT_EQ(filtered->above, 18.75);
  EXPECT_DOUBLE_EQ(filtered->turns_above, 9.375);
}

TEST(Vibration, LostSamplesDoNotBendTheMotion) {
  const std::optional<FilteredImu> filtered = WithoutVibration(Shaken(0.2, 0.1));
  ASSERT_TRUE(filtered);
  EXPECT_LT(RmsError(filtered->samples), 0.05);
}

TEST(Vibration, StampsInPairsAreAsGoodAsEvenOnes) {
  std::vector<ImuSample> samples = Shaken(3.0, 0.0, 27.0);
  for (std::size_t k = 1; k < samples.size(); k += 2) {
    const double time = samples[k - 1].time + 1e-7;
    samples[k] = samples[k - 1];
    samples[k].time = time;
  }
  const std::optional<FilteredImu> filtered = WithoutVibration(samples);
  ASSERT_TRUE(filtered);
  EXPECT_LT(RmsError(filtered->samples), 0.2);
}

TEST(Vibration, NothingIsMadeAcrossAGap) {
  std::vector<ImuSample> samples = Shaken(3.0);
  samples.erase(samples.begin() + 1000, samples.begin() + 1200);  // 5 to 6 s
  const std::optional<FilteredImu> filtered = WithoutVibration(samples);
  ASSERT_TRUE(filtered);
  const double longest = LongestPeriod(filtered->samples);
  EXPECT_GT(longest, 1.0);
  EXPECT_LT(longest, 1.3);
  EXPECT_LT(LargestError(filtered->samples), 0.1);
}

// A phone's log: seven samples lost at once. Knots lie 40 ms apart at the finest, and must not be without
// samples.
TEST(Vibration, AShortGapCostsLittleMoreThanItself) {
  std::vector<ImuSample> samples = Shaken(0.05);
  samples.erase(samples.begin() + 1000, samples.begin() + 1007);
  const std::optional<FilteredImu> filtered = WithoutVibration(samples);
  ASSERT_TRUE(filtered);
  const double longest = LongestPeriod(filtered->samples);
  EXPECT_GT(longest, 0.04);
  EXPECT_LT(longest, 0.1);
  EXPECT_LT(LargestError(filtered->samples), 0.05);
}

}  // namespace
}  // namespace mlic::vibration_test
