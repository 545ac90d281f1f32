#include "mlic_ros/bag/drive_bag_writer.h"

#include <gtest/gtest.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_ros/bag/camera_messages.h"
#include "mlic_ros/bag/driver_messages.h"

namespace mlic::drive_bag_writer_test {
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

sim::SimulatedCamera Camera(sim::ImageEncoding encoding) {
  sim::SimulatedCamera camera;
  camera.name = camera.frame_id = "camera" + std::to_string(static_cast<int>(encoding));
  camera.topic = "/" + camera.name + (IsCompressed(encoding) ? "/image_raw/compressed" : "/image_raw");
  camera.calibration.time_offset = -0.02;
  camera.intrinsics = IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 96, 64, 90.0);
  camera.encoding = encoding;
  camera.camera_info = sim::CameraInfoContent::kTrue;
  return camera;
}

// Keeps what a drive shows of its cameras.
struct ImageCollector : sim::DriveSink {
  std::map<std::size_t, std::vector<sim::SimulatedImage>> images;
  void OnImu(const sim::SimulatedImuMessage&) override {}
  void OnScan(sim::SimulatedScan) override {}
  void OnImage(sim::SimulatedImage image) override { images[image.camera].push_back(std::move(image)); }
};

TEST(DriveBagWriter, WritesImagesOfAllEncodings) {
  sim::SensorSet sensors;
  sensors.imu.T_body_imu.translation << 0, 0, 1.5;
  const char* const names[] = {"mono8", "bgr8", "bayer_rggb8"};
  for (const auto encoding :
       {sim::ImageEncoding::kMono8, sim::ImageEncoding::kBgr8, sim::ImageEncoding::kBayerRggb8,
        sim::ImageEncoding::kJpeg, sim::ImageEncoding::kMonoJpeg}) {
    sensors.cameras.push_back(Camera(encoding));
  }
  sim::SimulationOptions options;
  options.duration = 0.5;
  const fs::path path = fs::path(testing::TempDir()) / "mlic_sim_images_test.bag";
  int written = 0;
  {
    DriveBagWriter writer(path, sensors, [&](double, int images) { written = images; });
    sim::Simulate(sensors, options, writer);
    writer.Finish();
  }
  EXPECT_EQ(written, 30);  // six of each: the first and the last moment count
  ImageCollector expected;
  sim::Simulate(sensors, options, expected);
  rosbag::Bag bag(path.string(), rosbag::bagmode::Read);
  for (std::size_t c = 0; c < sensors.cameras.size(); ++c) {
    const sim::SimulatedCamera& camera = sensors.cameras[c];
    SCOPED_TRACE(camera.topic);
    std::size_t next = 0;
    rosbag::View view(bag, rosbag::TopicQuery(camera.topic));
    for (const rosbag::MessageInstance& message : view) {
      const sim::SimulatedImage& image = expected.images[c].at(next++);
      const cv::Mat& pixels = image.pixels;
      if (const auto raw = message.instantiate<sensor_msgs::Image>()) {
        ASSERT_LT(c, 3u);
        EXPECT_EQ(raw->encoding, names[c]);
        EXPECT_EQ(raw->header.stamp.toNSec(), static_cast<std::uint64_t>(image.stamp));
        const std::vector<std::uint8_t> bytes(pixels.datastart, pixels.dataend);
        EXPECT_EQ(raw->data, bytes);
        EXPECT_EQ(raw->step * raw->height, bytes.size());
      } else if (const auto compressed = message.instantiate<sensor_msgs::CompressedImage>()) {
        const cv::Mat decoded = cv::imdecode(compressed->data, cv::IMREAD_UNCHANGED);
        ASSERT_EQ(decoded.type(), pixels.type());
        EXPECT_LT(
            cv::norm(decoded, pixels, cv::NORM_L1) / static_cast<double>(pixels.total() * pixels.channels()),
            6.0);
      } else {
        ADD_FAILURE() << message.getDataType();
      }
    }
    EXPECT_EQ(next, 6u);
    rosbag::View infos(bag, rosbag::TopicQuery("/" + camera.name + "/camera_info"));
    ASSERT_EQ(infos.size(), 6u);
    const auto info = infos.begin()->instantiate<sensor_msgs::CameraInfo>();
    EXPECT_EQ(info->K[0], camera.intrinsics.parameters[0]);
    EXPECT_EQ(info->distortion_model, "plumb_bob");
    EXPECT_EQ(info->D.size(), 5u);
  }
  bag.close();
  fs::remove(path);
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
}  // namespace mlic::drive_bag_writer_test
