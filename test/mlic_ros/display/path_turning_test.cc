#include "mlic_ros/display/path_turning.h"

#include <gtest/gtest.h>

#include "mlic_core/geometry/so3.h"

namespace mlic::path_turning_test {
namespace {

// Along x at 1 m/s, from `turns_from` on turning about z.
std::vector<StampedPose> Drive(double seconds, double turns_from, double rate) {
  std::vector<StampedPose> poses;
  for (int k = 0; k <= static_cast<int>(100.0 * seconds); ++k) {
    const double t = 0.01 * k;
    const double yaw = rate * std::max(0.0, t - turns_from);
    poses.push_back({static_cast<TimeNs>(1700000000000000000 + k * 10000000LL),
                     {FromRollPitchYaw({0.0, 0.0, yaw}), Eigen::Vector3d(t, 0.0, 0.0)}});
  }
  return poses;
}

TEST(PathTurning, IsTheRateOfTurn) {
  const PathTurning turning = TurningAlong(Drive(10.0, 5.0, 0.4));
  ASSERT_EQ(turning.rates.size(), 1001u);
  EXPECT_EQ(turning.rates[200], 0.0);
  EXPECT_NEAR(turning.rates[500], 0.2, 1e-9) << "half of its second turns";
  EXPECT_NEAR(turning.rates[800], 0.4, 1e-9);
  EXPECT_NEAR(turning.rates.back(), 0.4, 1e-9);
  EXPECT_EQ(turning.scale, 50.0) << "22.9 deg/s";
  EXPECT_EQ(ColourOfRate(0.0, 50.0), ColourOfRate(-0.0, 50.0));
  EXPECT_NE(ColourOfRate(0.1, 50.0), ColourOfRate(0.4, 50.0));
  EXPECT_EQ(ColourOfRate(2.0, 50.0), ColourOfRate(3.0, 50.0)) << "beyond the scale";
}

TEST(PathTurning, AStraightDriveHasAScaleAndAShortOneIsStill) {
  EXPECT_EQ(TurningAlong(Drive(3.0, 9.0, 0.0)).scale, 5.0);
  EXPECT_EQ(TurningAlong(Drive(0.0, 0.0, 1.0)).rates, (std::vector<double>{0.0}));
  EXPECT_TRUE(TurningAlong({}).rates.empty());
  EXPECT_TRUE(MakeTurningMarkers({}, {}, 0.0).markers.empty());
}

TEST(PathTurning, LongPathsAreThinnedOutAndColouredPointByPoint) {
  const std::vector<StampedPose> drive = Drive(120.0, 60.0, 0.4);
  const auto markers = MakeTurningMarkers(drive, TurningAlong(drive), 0.0).markers;
  ASSERT_EQ(markers.size(), 2u);
  EXPECT_EQ(markers[0].action, visualization_msgs::Marker::DELETEALL);
  const visualization_msgs::Marker& line = markers[1];
  EXPECT_EQ(line.header.frame_id, "map");
  EXPECT_LE(line.points.size(), 5000u);
  EXPECT_GE(line.points.size(), 4000u);
  ASSERT_EQ(line.points.size(), line.colors.size());
  EXPECT_LT(line.colors.front().r, line.colors.back().r);
}

TEST(PathTurning, TheLineIsLeftOutAroundTheRig) {
  // To 10 m and back to 5 m, where the rig stands.
  std::vector<StampedPose> drive = Drive(15.0, 5.0, 0.4);
  for (StampedPose& pose : drive) {
    double& x = pose.pose.translation.x();
    if (x > 10.0) x = 20.0 - x;
  }
  const auto markers = MakeTurningMarkers(drive, TurningAlong(drive), 0.5).markers;
  ASSERT_EQ(markers.size(), 3u) << "before it passes the place, and after";
  EXPECT_NEAR(markers[1].points.front().x, 0.0, 1e-9);
  EXPECT_NEAR(markers[1].points.back().x, 4.5, 0.011);
  EXPECT_NEAR(markers[2].points.front().x, 5.5, 0.011);
  EXPECT_NEAR(markers[2].points.back().x, 5.5, 0.011);
  EXPECT_NE(markers[1].id, markers[2].id);
  for (const visualization_msgs::Marker& piece : markers) EXPECT_EQ(piece.colors.size(), piece.points.size());
}

}  // namespace
}  // namespace mlic::path_turning_test
