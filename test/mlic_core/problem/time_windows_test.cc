#include "mlic_core/problem/time_windows.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "mlic_core/common/random.h"

namespace mlic::time_windows_test {
namespace {

CalibrationState TwoLidarsAndACamera() {
  CalibrationState state;
  state.lidars.resize(2);
  state.lidars[1].time_offset = 0.3;
  state.cameras.resize(1);
  state.drives.resize(1);
  return state;
}

TEST(TimeWindows, PutPointsBackWhereTheyAreSeenMost) {
  LandmarkSet set;
  set.points.resize(2);
  set.begin = {0};
  for (const std::vector<double>& times :
       {std::vector<double>{0.0, 1.0, 20.0, 21.0, 22.0, 50.0}, {0.0, 30.0}}) {
    for (const double t : times) set.observations.push_back({0, 1.0f, t, Eigen::Vector2d::Zero()});
    set.begin.push_back(set.observations.size());
  }
  std::vector<std::size_t> origins;
  LandmarkSet split = SplitPoints(set, TwoLidarsAndACamera(), 0, 10.0, &origins);
  ASSERT_EQ(origins, (std::vector<std::size_t>{0, 0}));
  EXPECT_EQ(split.begin, (std::vector<std::size_t>{0, 2, 5}));
  split.points[0].position = Eigen::Vector3d(1.0, 0.0, 0.0);
  split.points[1].position = Eigen::Vector3d(2.0, 0.0, 0.0);
  set.points[1].position = Eigen::Vector3d(3.0, 0.0, 0.0);
  const std::vector<PointLandmark> merged = MergePoints(set.points, split, origins);
  EXPECT_EQ(merged[0].position.x(), 2.0);
  EXPECT_EQ(merged[1].position.x(), 3.0);
}

// Images at 10 Hz, exactly as far apart as a stretch is long.
TEST(TimeWindows, DoNotDependOnTheRoundingOfAnOffset) {
  LandmarkSet set;
  set.begin = {0};
  for (int p = 0; p < 50; ++p) {
    set.points.emplace_back();
    for (const int image : {p, p + 100}) {
      set.observations.push_back({0, 1.0f, 0.037 + 0.1 * image, Eigen::Vector2d::Zero()});
    }
    set.begin.push_back(set.observations.size());
  }
  CalibrationState state = TwoLidarsAndACamera();
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    state.cameras[0].sensor.time_offset = 1e-2 * random.Normal();
    std::vector<std::size_t> origins;
    EXPECT_EQ(SplitPoints(set, state, 0, 10.0, &origins).points.size(), 50u);
  }
}

TEST(TimeWindows, KeepPointsOnTheMapWholeWithTheirLidarPoint) {
  LandmarkSet set;
  set.points.resize(3);
  set.lidar_points.resize(3);
  set.lidar_points[0].lidar = 1;
  set.lidar_points[0].time = 5.0;
  set.lidar_points[2].lidar = 0;
  for (const double t : {0.0, 40.0, 1.0, 2.0, 3.0}) {
    set.observations.push_back({0, 1.0f, t, Eigen::Vector2d::Zero()});
  }
  set.begin = {0, 2, 4, 5};
  std::vector<std::size_t> origins;
  const LandmarkSet split = SplitPoints(set, TwoLidarsAndACamera(), 0, 10.0, &origins);
  ASSERT_EQ(origins, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(split.begin, set.begin);
  EXPECT_EQ(split.lidar_points[0].time, 5.0);
  EXPECT_FALSE(split.IsOnMap(1));
  EXPECT_TRUE(split.IsOnMap(2));
}

}  // namespace
}  // namespace mlic::time_windows_test
