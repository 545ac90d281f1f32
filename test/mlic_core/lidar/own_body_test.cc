#include "mlic_core/lidar/own_body.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"

namespace mlic::own_body_test {
namespace {

constexpr float kBodyMark = 7.0f, kGroundMark = 3.0f;

// A LiDAR 1.8 m over flat ground that drives past posts at `speed`; the vehicle's mast stands 1.2 m behind
// it.
LidarRecording Drive(double speed) {
  Random random(4);
  LidarRecording recording;
  const auto add = [&](LidarScan* scan, double x, double y, double z, float mark) {
    LidarPoint point;
    point.position = Eigen::Vector3d(x, y, z).cast<float>();
    point.position *= static_cast<float>(1.0 + 0.02 * random.Normal() / point.position.norm());
    point.intensity = mark;
    scan->points.push_back(point);
  };
  for (int s = 0; s < 100; ++s) {
    LidarScan scan;
    scan.time = 0.1 * s;
    const double travelled = speed * scan.time;
    for (int k = 0; k < 40; ++k)
      add(&scan, -1.2, 0.3 * random.Uniform(), random.Uniform(-0.5, 0.5), kBodyMark);
    for (int k = 0; k < 3000; ++k) {
      const double angle = random.Uniform(0.0, 2.0 * M_PI), range = random.Uniform(2.0, 12.0);
      add(&scan, range * std::cos(angle), range * std::sin(angle), -1.8, kGroundMark);
    }
    for (int post = 0; post < 40; ++post) {
      const double x = 7.3 * post - 40.0 - travelled;
      for (int k = 0; k < 60; ++k) add(&scan, x, post % 2 ? 2.5 : -8.0, random.Uniform(-1.0, 8.0), 0.0f);
    }
    recording.scans.push_back(scan);
  }
  return recording;
}

std::size_t Count(const LidarRecording& recording, float mark) {
  std::size_t count = 0;
  for (const LidarScan& scan : recording.scans) {
    for (const LidarPoint& point : scan.points) count += point.intensity == mark ? 1 : 0;
  }
  return count;
}

TEST(OwnBody, IsTakenOutAndTheFlatGroundStays) {
  LidarRecording recording = Drive(5.0);
  const std::size_t posts = Count(recording, 0.0f), ground = Count(recording, kGroundMark);
  const std::size_t body = Count(recording, kBodyMark);
  const std::size_t removed = RemoveOwnBody(&recording);
  EXPECT_LT(Count(recording, kBodyMark), body / 100);
  EXPECT_EQ(Count(recording, kGroundMark), ground);
  EXPECT_GT(Count(recording, 0.0f), posts * 99 / 100);
  EXPECT_GE(removed, body * 99 / 100);
}

TEST(OwnBody, NothingIsTakenFromAParkedRig) {
  LidarRecording recording = Drive(0.0);
  EXPECT_EQ(RemoveOwnBody(&recording), 0u);
}

}  // namespace
}  // namespace mlic::own_body_test
