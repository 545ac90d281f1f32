#include "mlic_core/initialization/knot_spacing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"

namespace mlic {
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

}  // namespace
}  // namespace mlic
