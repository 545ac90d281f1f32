#include "mlic_ros/display/frame_prefix.h"

#include <gtest/gtest.h>

namespace mlic::frame_prefix_test {
namespace {

TEST(FramePrefix, HasOneSlashBehind) {
  EXPECT_EQ(ToFramePrefix("mlic"), "mlic/");
  EXPECT_EQ(ToFramePrefix("/a/b/"), "a/b/");
  EXPECT_EQ(ToFramePrefix(""), "");
  EXPECT_EQ(ToFramePrefix("/"), "");
}

TEST(FramePrefix, StandsBeforeBothEndsOfAFrame) {
  geometry_msgs::TransformStamped frame;
  frame.header.frame_id = "map";
  frame.child_frame_id = "imu_link";
  AddFramePrefix("mlic/", &frame);
  EXPECT_EQ(frame.header.frame_id, "mlic/map");
  EXPECT_EQ(frame.child_frame_id, "mlic/imu_link");
}

TEST(FramePrefix, StandsBeforeAllFramesOfAPath) {
  nav_msgs::Path path;
  path.header.frame_id = "map";
  path.poses.resize(2);
  path.poses[1].header.frame_id = "map";
  AddFramePrefix("mlic/", &path);
  EXPECT_EQ(path.header.frame_id, "mlic/map");
  EXPECT_EQ(path.poses[1].header.frame_id, "mlic/map");
}

}  // namespace
}  // namespace mlic::frame_prefix_test
