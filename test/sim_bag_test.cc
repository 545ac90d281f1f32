#include <gtest/gtest.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "mlic_core/common/error.h"
#include "mlic_ros/drive_bag_writer.h"
#include "mlic_ros/driver_messages.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

sim::SimulatedLidar Lidar(sim::PointLayout layout, bool stamp_at_end = false) {
  sim::SimulatedLidar lidar;
  lidar.name = "lidar", lidar.topic = "/lidar/points", lidar.frame_id = "lidar_frame";
  lidar.layout = layout;
  lidar.stamp_at_end = stamp_at_end;
  lidar.model.rings = 2;
  lidar.model.azimuth_steps = 3;
  return lidar;
}

// Three columns of two rings, every 20 ms; the third beam does not come back.
sim::SimulatedScan SmallScan(bool stamp_at_end = false) {
  sim::SimulatedScan scan;
  scan.lidar = 0;
  scan.start = 1700000000123456789LL;
  scan.stamp = scan.start + (stamp_at_end ? 100000000 : 0);
  scan.received = scan.start + 104000000;
  for (int i = 0; i < 6; ++i) {
    sim::SimulatedPoint point;
    point.time = 0.02 * (i / 2);
    point.ring = static_cast<std::uint16_t>(i % 2);
    point.returned = i != 2;
    if (point.returned) point.position = Eigen::Vector3f(1.0f + i, 2.0f, 3.0f), point.intensity = 10.0f * i;
    scan.points.push_back(point);
  }
  return scan;
}

TEST(DriverMessages, VelodyneTimesAreRelativeToTheStampAndMissingBeamsLeftOut) {
  for (bool at_end : {false, true}) {
    sensor_msgs::PointCloud2 cloud =
        MakePointCloud(Lidar(sim::PointLayout::kVelodyne, at_end), SmallScan(at_end));
    EXPECT_EQ(cloud.header.frame_id, "lidar_frame");
    EXPECT_EQ(cloud.header.stamp.toNSec(), static_cast<std::uint64_t>(SmallScan(at_end).stamp));
    ASSERT_EQ(cloud.width * cloud.height, 5u);
    EXPECT_EQ(cloud.data.size(), 5u * 22u);
    sensor_msgs::PointCloud2Iterator<float> x(cloud, "x"), time(cloud, "time");
    sensor_msgs::PointCloud2Iterator<std::uint16_t> ring(cloud, "ring");
    EXPECT_FLOAT_EQ(*(x + 4), 6.0f);
    EXPECT_EQ(*(ring + 4), 1);
    EXPECT_NEAR(*(time + 4), at_end ? -0.06f : 0.04f, 1e-7);
  }
}

TEST(DriverMessages, OusterIsOrganisedWithZeroPoints) {
  sensor_msgs::PointCloud2 cloud = MakePointCloud(Lidar(sim::PointLayout::kOuster), SmallScan());
  EXPECT_EQ(cloud.height, 2u);
  EXPECT_EQ(cloud.width, 3u);
  EXPECT_TRUE(cloud.is_dense);
  sensor_msgs::PointCloud2Iterator<float> x(cloud, "x");
  sensor_msgs::PointCloud2Iterator<std::uint32_t> t(cloud, "t"), range(cloud, "range");
  sensor_msgs::PointCloud2Iterator<std::uint16_t> ring(cloud, "ring");
  EXPECT_FLOAT_EQ(*(x + 1), 0.0f);  // row 0, column 1: the beam that did not come back
  EXPECT_EQ(*(range + 1), 0u);
  EXPECT_FLOAT_EQ(*(x + 5), 6.0f);  // row 1, column 2
  EXPECT_EQ(*(ring + 5), 1);
  EXPECT_EQ(*(t + 5), 40000000u);
  EXPECT_EQ(*(range + 5), 7000u);
}

TEST(DriverMessages, HesaiAndRobosenseTimesAreAbsolute) {
  for (const auto layout : {sim::PointLayout::kHesai, sim::PointLayout::kRobosense}) {
    sensor_msgs::PointCloud2 cloud = MakePointCloud(Lidar(layout), SmallScan());
    const bool keeps_missing = layout == sim::PointLayout::kRobosense;
    ASSERT_EQ(cloud.width * cloud.height, keeps_missing ? 6u : 5u);
    EXPECT_EQ(cloud.is_dense, !keeps_missing);
    sensor_msgs::PointCloud2Iterator<float> x(cloud, "x");
    sensor_msgs::PointCloud2Iterator<double> timestamp(cloud, "timestamp");
    const int last = keeps_missing ? 5 : 4;
    EXPECT_NEAR(*(timestamp + last), 1700000000.163456789, 3e-7);
    if (keeps_missing) {
      EXPECT_TRUE(std::isnan(*(x + 2)));
    }
  }
}

TEST(DriverMessages, LayoutWithoutTimeHasNone) {
  const sensor_msgs::PointCloud2 cloud = MakePointCloud(Lidar(sim::PointLayout::kNoTime), SmallScan());
  for (const auto& field : cloud.fields)
    EXPECT_EQ(field.name.find('t'), field.name == "intensity" ? 2u : std::string::npos);
  EXPECT_EQ(cloud.width, 5u);
}

TEST(DriverMessages, LivoxCountsFromItsTimebase) {
  const LivoxMessage message = MakeLivoxMessage(Lidar(sim::PointLayout::kLivox), SmallScan());
  EXPECT_EQ(message.timebase, 1700000000123456789ull);
  ASSERT_EQ(message.points.size(), 6u);
  EXPECT_EQ(message.point_num, 6u);
  EXPECT_EQ(message.points[5].offset_time, 40000000u);
  EXPECT_EQ(message.points[2].x, 0.0f);
  EXPECT_EQ(message.points[5].reflectivity, 50);
}

TEST(DriveBagWriter, WritesAllTopicsAndNothingWithoutFinish) {
  sim::SensorSet sensors;
  sensors.imu.T_body_imu.translation << 0, 0, 1.5;
  for (const auto layout : {sim::PointLayout::kVelodyne, sim::PointLayout::kLivox}) {
    sensors.lidars.push_back(Lidar(layout));
    sensors.lidars.back().topic += layout == sim::PointLayout::kLivox ? "_livox" : "";
  }
  sim::SimulationOptions options;
  options.duration = 1.0;
  const fs::path path = fs::path(testing::TempDir()) / "mlic_sim_bag_test.bag";
  fs::remove(path);
  {
    DriveBagWriter writer(path, sensors, nullptr);
    sim::Simulate(sensors, options, writer);
  }
  EXPECT_FALSE(fs::exists(path));
  EXPECT_FALSE(fs::exists(path.string() + ".part"));
  {
    DriveBagWriter writer(path, sensors, nullptr);
    sim::Simulate(sensors, options, writer);
    writer.Finish();
  }
  rosbag::Bag bag(path.string(), rosbag::bagmode::Read);
  std::map<std::string, int> counts;
  rosbag::View view(bag);
  for (const rosbag::MessageInstance& message : view) {
    ++counts[message.getDataType()];
    if (const auto imu = message.instantiate<sensor_msgs::Imu>()) {
      const auto& a = imu->linear_acceleration;
      EXPECT_NEAR(std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z), 9.81, 2.0);
    }
  }
  EXPECT_EQ(counts["sensor_msgs/Imu"], 201);
  EXPECT_EQ(counts["sensor_msgs/PointCloud2"], 10);
  EXPECT_EQ(counts["livox_ros_driver/CustomMsg"], 10);
  bag.close();
  fs::remove(path);
  EXPECT_THROW(DriveBagWriter("/no/such/directory/x.bag", sensors, nullptr), InputError);
}

}  // namespace
}  // namespace mlic
