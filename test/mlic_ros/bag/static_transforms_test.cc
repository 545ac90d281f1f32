#include "mlic_ros/bag/static_transforms.h"

#include <gtest/gtest.h>
#include <tf2_msgs/TFMessage.h>

#include "support/files.h"
#include "support/test_bags.h"

namespace mlic::static_transforms_test {
namespace {

// A turn about z by `yaw` after a step along x.
tf2_msgs::TFMessage Transform(const std::string& parent, const std::string& child, double x, double yaw) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = RosTimeAt(kBagStart);
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  transform.transform.translation.x = x;
  transform.transform.rotation.w = std::cos(0.5 * yaw);
  transform.transform.rotation.z = std::sin(0.5 * yaw);
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  return message;
}

class StaticTransformsTest : public ::testing::Test {
 protected:
  template <typename Write>
  StaticTransforms Read(const Write& write) {
    const std::string path = (directory_.Path() / "a.bag").string();
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    write([&](const std::string& topic, double seconds, const tf2_msgs::TFMessage& message) {
      bag.write(topic, RosTimeAt(TimeFrom(kBagStart, seconds)), message);
    });
    bag.close();
    return StaticTransforms(BagSet({path}));
  }
  const TemporaryDirectory directory_;
};

TEST_F(StaticTransformsTest, LinksFramesOverTheTree) {
  const StaticTransforms tree = Read([](const auto& write) {
    write("/tf_static", 0.0, Transform("/base", "imu", 1.0, 0.5 * M_PI));
    write("/tf_static", 0.1, Transform("base", "mast", 5.0, 0.0));
    write("/tf_static", 0.2, Transform("mast", "/lidar", 1.0, 0.0));
  });
  EXPECT_FALSE(tree.empty());
  const auto T_imu_lidar = tree.Find("imu", "lidar");
  ASSERT_TRUE(T_imu_lidar.has_value());
  EXPECT_TRUE(T_imu_lidar->translation.isApprox(Eigen::Vector3d(0.0, -5.0, 0.0), 1e-12));
  EXPECT_NEAR(T_imu_lidar->rotation.angularDistance(Eigen::Quaterniond::Identity()), 0.5 * M_PI, 1e-12);
  EXPECT_TRUE(tree.Find("/imu", "/lidar").has_value());
  EXPECT_FALSE(tree.Find("imu", "camera").has_value());
}

// Joint publishers of old write fixed joints to /tf, beside those that move.
TEST_F(StaticTransformsTest, TakesFromTfOnlyWhatNeverMoves) {
  const StaticTransforms tree = Read([](const auto& write) {
    write("/tf_static", 0.0, Transform("base", "imu", 1.0, 0.0));
    for (int i = 0; i < 5; ++i) {
      write("/tf", 0.1 * i, Transform("base", "lidar", 3.0, 0.0));
      write("/tf", 0.1 * i, Transform("base", "imu", 9.0, 0.0));
      write("/tf", 0.1 * i, Transform("odom", "base", 0.1 * i, 0.0));
    }
    write("/tf", 1.0, Transform("base", "once", 1.0, 0.0));
  });
  const auto T_imu_lidar = tree.Find("imu", "lidar");
  ASSERT_TRUE(T_imu_lidar.has_value());
  EXPECT_TRUE(T_imu_lidar->translation.isApprox(Eigen::Vector3d(2.0, 0.0, 0.0), 1e-12));
  EXPECT_FALSE(tree.Find("imu", "odom").has_value());
  EXPECT_FALSE(tree.Find("imu", "once").has_value());
}

TEST_F(StaticTransformsTest, LoopsAndNonsenseLinkNothing) {
  const StaticTransforms tree = Read([](const auto& write) {
    write("/tf_static", 0.0, Transform("a", "b", 1.0, 0.0));
    write("/tf_static", 0.1, Transform("b", "a", 1.0, 0.0));
    write("/tf_static", 0.2, Transform("imu", "imu", 1.0, 0.0));
    write("/tf_static", 0.3, Transform("imu", "lidar", std::numeric_limits<double>::quiet_NaN(), 0.0));
  });
  EXPECT_FALSE(tree.Find("a", "imu").has_value());
  EXPECT_FALSE(tree.Find("imu", "lidar").has_value());
}

}  // namespace
}  // namespace mlic::static_transforms_test
