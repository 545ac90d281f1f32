#include "mlic_core/lidar/scan_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "mlic_core/common/random.h"

namespace mlic::scan_filter_test {
namespace {

LidarPoint MakePoint(float x, float y, float z, float time) {
  LidarPoint point;
  point.position = Eigen::Vector3f(x, y, z);
  point.time = time;
  return point;
}

// Points on the walls of a room, in random order.
LidarScan RoomScan(std::size_t count, float half_width, std::uint64_t seed) {
  Random random(seed);
  LidarScan scan;
  for (std::size_t i = 0; i < count; ++i) {
    Eigen::Vector3f p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = half_width * static_cast<float>(random.Uniform(-1.0, 1.0));
    p[static_cast<int>(random.Next() % 3)] = random.Uniform() < 0.5 ? -half_width : half_width;
    scan.points.push_back(MakePoint(p.x(), p.y(), p.z(), static_cast<float>(random.Uniform(0.0, 0.1))));
  }
  return scan;
}

TEST(ScanFilter, CountsWhatItDrops) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  LidarScan scan;
  scan.points = {MakePoint(5.0f, 0.0f, 0.0f, 0.03f),    MakePoint(nan, 0.0f, 0.0f, 0.0f),
                 MakePoint(0.0f, 0.0f, 0.0f, 0.0f),     MakePoint(1.0f, 0.0f, 0.0f, nan),
                 MakePoint(0.1f, 0.1f, 0.1f, 0.0f),     MakePoint(400.0f, 0.0f, 0.0f, 0.0f),
                 MakePoint(5.01f, 0.01f, 0.01f, 0.01f), MakePoint(-5.0f, 0.0f, 0.0f, 0.02f)};
  const ScanFilterCounts counts = FilterScan(scan);
  EXPECT_EQ(counts.not_finite, 2u);
  EXPECT_EQ(counts.too_near, 2u);
  EXPECT_EQ(counts.too_far, 1u);
  EXPECT_EQ(counts.thinned_out, 0u);
  EXPECT_EQ(counts.kept, 3u);
  ASSERT_EQ(scan.points.size(), 3u);  // in order of time
  EXPECT_FLOAT_EQ(scan.points[0].position.x(), 5.01f);
  EXPECT_FLOAT_EQ(scan.points[1].position.x(), -5.0f);
  EXPECT_FLOAT_EQ(scan.points[2].position.x(), 5.0f);
}

std::vector<float> Times(const LidarScan& scan) {
  std::vector<float> times;
  for (const LidarPoint& point : scan.points) times.push_back(point.time);
  return times;
}

TEST(ScanFilter, ThinsToABoundedNumberInOrderOfTime) {
  LidarScan scan = RoomScan(60000, 8.0f, 1);
  const ScanFilterCounts counts = FilterScan(scan);
  EXPECT_EQ(counts.kept, scan.points.size());
  EXPECT_EQ(counts.kept + counts.thinned_out, 60000u);
  EXPECT_NEAR(static_cast<double>(counts.kept), 12000.0, 500.0);
  const std::vector<float> times = Times(scan);
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
}

TEST(ScanFilter, LeavesASmallScanWhole) {
  LidarScan scan = RoomScan(9000, 8.0f, 2);
  EXPECT_EQ(FilterScan(scan).kept, 9000u);
}

// A choice that depended on the ranges would favour points whose noise points one way.
TEST(ScanFilter, TheChoiceDoesNotDependOnTheRanges) {
  LidarScan scan = RoomScan(40000, 8.0f, 3);
  LidarScan noisy = scan;
  Random random(4);
  for (LidarPoint& point : noisy.points) point.position *= 1.0f + 0.01f * static_cast<float>(random.Normal());
  FilterScan(scan);
  FilterScan(noisy);
  EXPECT_EQ(Times(scan), Times(noisy));
}

TEST(ScanFilter, EmptyScanStaysEmpty) {
  LidarScan scan;
  EXPECT_EQ(FilterScan(scan).kept, 0u);
  EXPECT_TRUE(scan.points.empty());
}

}  // namespace
}  // namespace mlic::scan_filter_test
