#include <gtest/gtest.h>

#include <algorithm>

#include "mlic_core/calibration/time_windows.h"
#include "mlic_core/common/random.h"

namespace mlic {
namespace {

CalibrationState TwoLidarsAndACamera() {
  CalibrationState state;
  state.lidars.resize(2);
  state.lidars[1].time_offset = 0.3;
  state.cameras.resize(1);
  return state;
}

// A plane that two LiDARs see from 0 to `end` seconds, 10 points a second each, in order of LiDAR and time.
PlaneAssociation OnePlane(double end) {
  PlaneAssociation association;
  association.planes.resize(1);
  association.planes[0].center = Eigen::Vector3d(1.0, 2.0, 3.0);
  for (int lidar = 0; lidar < 2; ++lidar) {
    for (double t = 0.0; t < end; t += 0.1) {
      PlaneObservation o{};
      o.position.setZero();
      o.lidar = lidar;
      o.time = t;
      association.observations.push_back(o);
    }
  }
  association.begin = {0, association.observations.size()};
  return association;
}

TEST(TimeWindows, LeaveShortSightsAlone) {
  const PlaneAssociation plane = OnePlane(9.0);
  const PlaneAssociation split = SplitPlanes(plane, TwoLidarsAndACamera(), 10.0);
  ASSERT_EQ(split.planes.size(), 1u);
  EXPECT_EQ(split.begin, plane.begin);
  for (std::size_t k = 0; k < plane.observations.size(); ++k) {
    EXPECT_EQ(split.observations[k].time, plane.observations[k].time);
    EXPECT_EQ(split.observations[k].lidar, plane.observations[k].lidar);
  }
}

TEST(TimeWindows, CutLongSightsOnTheClockOfTheImuAndKeepTheOrder) {
  const CalibrationState state = TwoLidarsAndACamera();
  const PlaneAssociation plane = OnePlane(25.0);
  const PlaneAssociation split = SplitPlanes(plane, state, 10.0);
  ASSERT_EQ(split.planes.size(), 3u);
  EXPECT_EQ(split.observations.size(), plane.observations.size());
  double end_of_last = -1.0;
  for (std::size_t p = 0; p < 3; ++p) {
    EXPECT_EQ(split.planes[p].center, plane.planes[0].center);
    double first = 1e9, last = -1e9;
    for (std::size_t k = split.begin[p]; k < split.begin[p + 1]; ++k) {
      const PlaneObservation& o = split.observations[k];
      const double t = o.time + state.lidars[o.lidar].time_offset;
      first = std::min(first, t);
      last = std::max(last, t);
      if (k == split.begin[p]) continue;
      const PlaneObservation& before = split.observations[k - 1];
      EXPECT_TRUE(before.lidar < o.lidar || (before.lidar == o.lidar && before.time < o.time));
    }
    EXPECT_LE(last - first, 10.0);
    EXPECT_GT(first, end_of_last);
    end_of_last = last;
  }
}

TEST(TimeWindows, LeaveOutStretchesWithFewPoints) {
  const PlaneAssociation split = SplitPlanes(OnePlane(10.8), TwoLidarsAndACamera(), 10.0);
  EXPECT_EQ(split.planes.size(), 1u);
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
  LandmarkSet split = SplitPoints(set, TwoLidarsAndACamera(), 10.0, &origins);
  ASSERT_EQ(origins, (std::vector<std::size_t>{0, 0}));
  EXPECT_EQ(split.begin, (std::vector<std::size_t>{0, 2, 5}));
  split.points[0].position = Eigen::Vector3d(1.0, 0.0, 0.0);
  split.points[1].position = Eigen::Vector3d(2.0, 0.0, 0.0);
  set.points[1].position = Eigen::Vector3d(3.0, 0.0, 0.0);
  const std::vector<PointLandmark> merged = MergePoints(set.points, split, origins);
  EXPECT_EQ(merged[0].position.x(), 2.0);
  EXPECT_EQ(merged[1].position.x(), 3.0);
}

TEST(TimeWindows, KeepPointsOnTheMapWholeWithTheirLidarSight) {
  LandmarkSet set;
  set.points.resize(3);
  set.lidar_sights.resize(3);
  set.lidar_sights[0].lidar = 1;
  set.lidar_sights[0].time = 5.0;
  set.lidar_sights[2].lidar = 0;
  for (const double t : {0.0, 40.0, 1.0, 2.0, 3.0}) {
    set.observations.push_back({0, 1.0f, t, Eigen::Vector2d::Zero()});
  }
  set.begin = {0, 2, 4, 5};
  std::vector<std::size_t> origins;
  const LandmarkSet split = SplitPoints(set, TwoLidarsAndACamera(), 10.0, &origins);
  ASSERT_EQ(origins, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(split.begin, set.begin);
  EXPECT_EQ(split.lidar_sights[0].time, 5.0);
  EXPECT_FALSE(split.IsOnMap(1));
  EXPECT_TRUE(split.IsOnMap(2));
}

}  // namespace
}  // namespace mlic
