#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/error.h"
#include "mlic_core/common/random.h"
#include "mlic_core/evaluation/trajectory_error.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::trajectory_test {
namespace {

// A walk with turns about all axes, or about z alone; 100 Hz.
std::vector<StampedPose> Walk(double seconds, bool planar) {
  std::vector<StampedPose> walk;
  for (int i = 0; i < static_cast<int>(100 * seconds); ++i) {
    const double t = 0.01 * i, tilt = planar ? 0.0 : 0.4;
    StampedPose stamped;
    stamped.time = 1700000000000000000 + static_cast<TimeNs>(i) * 10000000;
    stamped.pose.translation << 5.0 * std::sin(0.3 * t), 2.5 * std::sin(0.6 * t), 0.75 * tilt * std::sin(t);
    stamped.pose.rotation =
        FromRollPitchYaw({tilt * std::sin(0.9 * t), tilt * std::cos(1.1 * t), 1.5 * std::sin(0.5 * t)});
    walk.push_back(stamped);
  }
  return walk;
}

RigidTransform Transform(const Eigen::Vector3d& rpy, const Eigen::Vector3d& translation) {
  return {FromRollPitchYaw(rpy), translation};
}

// The same motion seen in another world by a body mounted elsewhere.
std::vector<StampedPose> Seen(std::vector<StampedPose> walk, const RigidTransform& T_world_map,
                              const RigidTransform& T_imu_body) {
  for (StampedPose& stamped : walk) stamped.pose = T_world_map * stamped.pose * T_imu_body;
  return walk;
}

TEST(TrajectoryError, WorldAndMountingAreFound) {
  const auto walk = Walk(30.0, false);
  const RigidTransform T_world_map = Transform({0.1, -0.2, 2.8}, {100.0, -40.0, 7.0});
  const RigidTransform T_imu_body = Transform({-1.5, 0.3, 1.6}, {0.4, -0.8, 0.3});
  const TrajectoryError error = CompareTrajectories(walk, Seen(walk, T_world_map, T_imu_body));
  EXPECT_LT(error.translation_largest, 1e-8);
  EXPECT_LT(error.rotation_largest_deg, 1e-7);
  EXPECT_LT((error.T_imu_body.translation - T_imu_body.translation).norm(), 1e-8);
  EXPECT_LT(AngleBetween(error.T_imu_body.rotation, T_imu_body.rotation), 1e-8);
  EXPECT_LT((error.T_map_world * T_world_map.translation).norm(), 1e-7);
  ASSERT_FALSE(error.over_metres.empty());
  EXPECT_LT(error.over_metres.back().translation_rms, 1e-8);
}

TEST(TrajectoryError, PlanarMotionNeedsNoHeightOfTheMount) {
  const auto walk = Walk(30.0, true);
  const TrajectoryError error = CompareTrajectories(
      walk,
      Seen(walk, Transform({0.0, 0.0, 1.0}, {3.0, 2.0, 1.0}), Transform({0.0, 0.0, 0.5}, {1.0, 0.5, 2.0})));
  EXPECT_LT(error.translation_largest, 1e-8);
  EXPECT_LT((error.T_imu_body.translation - Eigen::Vector3d(1.0, 0.5, 0.0)).norm(), 1e-6);
}

TEST(TrajectoryError, DriftAndNoiseHaveTheSizeThatWasPutIn) {
  const auto walk = Walk(60.0, false);
  Random random(5);
  auto noisy = walk;
  for (StampedPose& stamped : noisy) {
    for (int a = 0; a < 3; ++a) stamped.pose.translation[a] += 0.01 * random.Normal();
    const Eigen::Vector3d turn(random.Normal(), random.Normal(), random.Normal());
    stamped.pose.rotation = stamped.pose.rotation * ExpQuaternion(0.002 * turn);
  }
  const TrajectoryError noise = CompareTrajectories(noisy, walk);
  EXPECT_NEAR(noise.translation_rms, 0.01 * std::sqrt(3.0), 0.001);
  EXPECT_NEAR(noise.rotation_rms_deg, 0.002 * std::sqrt(3.0) * 180.0 / M_PI, 0.01);
  // Two noisy ends for each part, whatever its length.
  EXPECT_NEAR(noise.over_metres[2].translation_rms, std::sqrt(2.0) * 0.01 * std::sqrt(3.0), 0.006);

  auto longer = walk;  // one percent too long
  for (StampedPose& stamped : longer) stamped.pose.translation *= 1.01;
  const TrajectoryError scale = CompareTrajectories(longer, walk);
  EXPECT_EQ(scale.over_metres[0].extent, 1.0);
  EXPECT_NEAR(scale.over_metres[0].translation_rms, 0.01, 0.003);
  EXPECT_GT(scale.translation_rms, 0.01) << "no scale is fitted";
}

TEST(TrajectoryError, LengthsAreThoseOfTheReference) {
  std::vector<StampedPose> line;
  for (int i = 0; i <= 1000; ++i) {
    StampedPose stamped;
    stamped.time = static_cast<TimeNs>(i) * 10000000;
    stamped.pose = Transform({0.0, 0.0, 0.001 * i}, {0.03 * i, 0.0, 0.0});
    line.push_back(stamped);
  }
  const TrajectoryError error = CompareTrajectories(line, line);
  EXPECT_NEAR(error.length, 30.0, 0.4);
  EXPECT_NEAR(error.turned_deg, 57.3, 0.8);
  ASSERT_EQ(error.over_metres.size(), 5u);  // 1, 2, 5, 10, 20 m
  ASSERT_EQ(error.over_degrees.size(), 2u);
}

TEST(TrajectoryError, AReferenceElsewhereInTimeIsRefused) {
  auto other = Walk(10.0, false);
  for (StampedPose& stamped : other) stamped.time += 3600000000000;
  EXPECT_THROW(CompareTrajectories(Walk(10.0, false), other), InputError);
}

TEST(TrajectoryError, TablesHoldTheNumbers) {
  const auto walk = Walk(30.0, false);
  auto longer = walk;
  for (StampedPose& stamped : longer) stamped.pose.translation *= 1.01;
  const TrajectoryError error = CompareTrajectories(longer, walk);
  EXPECT_NE(TableOf(error).find("absolute, aligned"), std::string::npos);
  const std::string csv = CsvOf(error);
  EXPECT_EQ(csv.find("kind,extent,count,translation_rms_m,rotation_rms_deg\nabsolute,,"), 0u);
  EXPECT_NE(csv.find("\nper_metres,1,"), std::string::npos);
  EXPECT_NE(csv.find("\nper_degrees,90,"), std::string::npos);
}

}  // namespace
}  // namespace mlic::trajectory_test
