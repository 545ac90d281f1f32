#include "mlic_ros/bag/pose_topic.h"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <unistd.h>

#include <filesystem>
#include <limits>

#include "mlic_core/common/error.h"

namespace mlic::pose_topic_test {
namespace {

constexpr TimeNs kStart = 1'700'000'000'000'000'000;

class PoseTopic : public testing::Test {
 protected:
  void SetUp() override {
    path_ =
        std::filesystem::temp_directory_path() / ("mlic_pose_topic_" + std::to_string(::getpid()) + ".bag");
    rosbag::Bag bag(path_.string(), rosbag::bagmode::Write);
    for (const int i : {0, 2, 1, 2, 3, 4}) {  // out of order, and one stamp twice
      ros::Time stamp;
      stamp.fromNSec(static_cast<std::uint64_t>(kStart + i * 100'000'000));
      nav_msgs::Odometry odometry;
      odometry.header.stamp = stamp;
      odometry.pose.pose.position.x = i;
      odometry.pose.pose.orientation.w = 0.6;
      odometry.pose.pose.orientation.z = 0.8;
      if (i == 3) odometry.pose.pose.position.y = std::numeric_limits<double>::quiet_NaN();
      bag.write("/odometry", stamp, odometry);
      geometry_msgs::PoseStamped pose;  // its quaternion is never set
      pose.header.stamp = stamp;
      bag.write("/unset", stamp, pose);
      geometry_msgs::TransformStamped transform;
      transform.header.stamp = stamp;
      transform.transform.translation.z = i;
      transform.transform.rotation.w = 1.0;
      bag.write("/transform", stamp, transform);
    }
    bag.close();
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string ErrorOf(const std::string& topic) const {
    try {
      ReadPoseTopic(BagSet({path_}), topic);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path path_;
};

TEST_F(PoseTopic, OdometryIsSortedAndCleaned) {
  const auto poses = ReadPoseTopic(BagSet({path_}), "/odometry");
  ASSERT_EQ(poses.size(), 4u);
  const int expected[] = {0, 1, 2, 4};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(poses[i].time, kStart + expected[i] * 100'000'000);
    EXPECT_EQ(poses[i].pose.translation.x(), expected[i]);
    EXPECT_NEAR(poses[i].pose.rotation.z(), 0.8, 1e-12);
  }
}

TEST_F(PoseTopic, TransformsAreReadToo) {
  const auto poses = ReadPoseTopic(BagSet({path_}), "/transform");
  ASSERT_EQ(poses.size(), 5u);
  EXPECT_EQ(poses[4].pose.translation.z(), 4.0);
}

TEST_F(PoseTopic, ErrorsSayWhatIsWrong) {
  EXPECT_NE(ErrorOf("/nowhere").find("/transform (geometry_msgs/TransformStamped)"), std::string::npos);
  EXPECT_NE(ErrorOf("/unset").find("unit quaternion"), std::string::npos);
}

}  // namespace
}  // namespace mlic::pose_topic_test
