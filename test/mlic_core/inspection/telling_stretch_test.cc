#include "mlic_core/inspection/telling_stretch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::telling_stretch_test {
namespace {

constexpr double kRate = 100.0;  // Hz

// Turns about z alone, and between two times about all axes.
std::vector<ImuSample> Drive(double seconds, double lively_from, double lively_to) {
  Random random(5);
  const auto white = [&] { return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()); };
  std::vector<ImuSample> samples;
  Eigen::Quaterniond attitude = Eigen::Quaterniond::Identity();
  for (int i = 0; i < static_cast<int>(seconds * kRate); ++i) {
    const double t = i / kRate;
    const double share = t >= lively_from && t < lively_to ? 0.5 : 0.0;
    const Eigen::Vector3d w(share * std::sin(1.3 * t), share * std::sin(1.7 * t), 0.5 * std::cos(2.0 * t));
    const Eigen::Vector3d force(std::sin(0.9 * t), std::cos(1.1 * t), kStandardGravity);
    samples.push_back({t, w + 1e-3 * white(), attitude.conjugate() * force + 1e-2 * white()});
    attitude = (attitude * ExpQuaternion(w / kRate)).normalized();
  }
  return samples;
}

TEST(TellingStretch, IsWhereTheMotionIsAboutAllAxes) {
  for (const double from : {0.0, 70.0, 160.0}) {
    const TimeInterval stretch =
        MostTellingStretch(Drive(200.0, from, from + 40.0), ImuConfig(), TypicalPoseNoise(), 40.0);
    EXPECT_NEAR(stretch.Duration(), 40.0, 1e-9);
    EXPECT_NEAR(stretch.start, from, 5.0 + 1e-9) << "half a step of a quarter of the duration";
  }
}

TEST(TellingStretch, IsAllOfAShortDrive) {
  const TimeInterval stretch =
      MostTellingStretch(Drive(30.0, 10.0, 20.0), ImuConfig(), TypicalPoseNoise(), 40.0);
  EXPECT_EQ(stretch.start, 0.0);
  EXPECT_NEAR(stretch.end, 30.0, 1.5 / kRate);
}

TEST(TellingStretch, OfADriveThatShowsNothingIsSomeStretchOfIt) {
  std::vector<ImuSample> still;
  for (int i = 0; i < 10000; ++i)
    still.push_back({0.01 * i, Eigen::Vector3d::Zero(), {0.0, 0.0, kStandardGravity}});
  const TimeInterval stretch = MostTellingStretch(still, ImuConfig(), TypicalPoseNoise(), 40.0);
  EXPECT_GE(stretch.start, 0.0);
  EXPECT_NEAR(stretch.Duration(), 40.0, 1e-9);
}

}  // namespace
}  // namespace mlic::telling_stretch_test
