#include "mlic_core/uncertainty/stamp_wander.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"

namespace mlic::stamp_wander_test {
namespace {

constexpr double kNoise = 1e-4;  // s, of the time error of one image

// Images at 3 Hz over 20 s whose stamps are too early by so much, s.
template <typename Course>
ScanSums Images(const Course& course, std::uint64_t seed) {
  Random random(seed);
  ScanSums sums;
  for (int k = 0; k < 60; ++k) {
    const double time = k / 3.0, information = 1.0 / (kNoise * kNoise);
    sums[time] = {information * (course(time) + kNoise * random.Normal()), information};
  }
  return sums;
}

TEST(StampWander, OfWhiteErrorsIsNone) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    EXPECT_FALSE(FindStampCourse(Images([](double) { return 3e-5; }, seed), false)) << seed;
  }
}

TEST(StampWander, IsFoundThroughNoise) {
  // About -cos's mean and slope over two periods, which are zero.
  const auto course = [](double time) { return -5e-4 * std::cos(2.0 * M_PI * time / 10.0); };
  double squares = 0.0;
  constexpr int kDraws = 20;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const std::optional<StampCourse> found = FindStampCourse(Images(course, seed), false);
    ASSERT_TRUE(found) << seed;
    double sum = 0.0;
    for (std::size_t k = 0; k < found->times.size(); ++k) {
      sum += found->shifts[k];
      squares += std::pow(found->shifts[k] - course(found->times[k]), 2) / (60.0 * kDraws);
    }
    EXPECT_NEAR(sum, 0.0, 1e-9);
    EXPECT_NEAR(found->At(-1.0), found->shifts.front(), 1e-12);
  }
  EXPECT_LT(std::sqrt(squares), 0.7 * kNoise);
}

TEST(StampWander, NeedsImages) {
  EXPECT_FALSE(FindStampCourse({}, false));
  EXPECT_FALSE(FindStampCourse({}, true));
}

}  // namespace
}  // namespace mlic::stamp_wander_test
