// Messages as a damaged or hostile bag may hold them.
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <opencv2/imgcodecs.hpp>

#include "mlic_ros/bag/cloud_decoder.h"
#include "mlic_ros/bag/image_reader.h"
#include "mlic_ros/bag/imu_messages.h"
#include "support/mutations.h"
#include "support/test_bags.h"

namespace mlic {
namespace {

constexpr int kMutants = 20000;

template <typename Message>
std::string Serialized(const Message& message) {
  std::string bytes(ros::serialization::serializationLength(message), '\0');
  ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(&bytes[0]),
                                     static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

SerializedMessage MessageOf(const std::string& type, const std::string& bytes) {
  return {type, std::vector<std::uint8_t>(bytes.begin(), bytes.end()), kBagStart};
}

std::string Cloud(std::uint32_t height, std::uint8_t time_type, const std::string& time) {
  using sensor_msgs::PointField;
  sensor_msgs::PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.height = height;
  cloud.width = 4;
  cloud.point_step = 32;
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.fields = {MakeField("x", 0, PointField::FLOAT32),          MakeField("y", 4, PointField::FLOAT32),
                  MakeField("z", 8, PointField::FLOAT32),          MakeField(time, 16, time_type),
                  MakeField("intensity", 12, PointField::FLOAT32), MakeField("ring", 24, PointField::UINT16)};
  cloud.data.assign(std::size_t{cloud.row_step} * height, 0x40);
  return Serialized(cloud);
}

std::string Livox() {
  LivoxMessage message;
  message.header.frame_id = "livox";
  message.timebase = kBagStart;
  message.point_num = 3;
  message.lidar_id = 0;
  for (std::uint8_t& byte : message.reserved) byte = 0;
  for (std::uint32_t i = 0; i < message.point_num; ++i)
    message.points.push_back({1000 * i, 1.0f, 2.0f, 3.0f, 10, 0, static_cast<std::uint8_t>(i)});
  return Serialized(message);
}

cv::Mat Pattern() {
  cv::Mat image(16, 24, CV_8UC3);
  cv::randu(image, 0, 255);
  return image;
}

std::string RawImage(const std::string& encoding, std::uint32_t bytes_of_pixel) {
  sensor_msgs::Image image;
  image.header.frame_id = "camera";
  image.encoding = encoding;
  image.width = 24;
  image.height = 16;
  image.step = image.width * bytes_of_pixel;
  image.data.assign(std::size_t{image.step} * image.height, 77);
  return Serialized(image);
}

std::string CompressedImage(const std::string& format) {
  sensor_msgs::CompressedImage image;
  image.format = format;
  cv::imencode("." + format, Pattern(), image.data);
  return Serialized(image);
}

void ReadCloud(const std::string& type, const std::string& bytes) {
  const SerializedMessage message = MessageOf(type, bytes);
  const bool sound = FaultOfCloud(message, "/points").empty();
  bool decoded = false;
  try {
    DecodeCloud(message, "/points", PointTimeFieldNames());
    decoded = true;
  } catch (const InputError&) {
  }
  EXPECT_EQ(sound, decoded);
}

TEST(Fuzz, PointCloud2) {
  using sensor_msgs::PointField;
  ReadMutants({Cloud(1, PointField::FLOAT32, "time"), Cloud(3, PointField::UINT32, "t"),
               Cloud(2, PointField::FLOAT64, "timestamp")},
              kMutants, [](const std::string& bytes) { ReadCloud("sensor_msgs/PointCloud2", bytes); });
}

TEST(Fuzz, Livox) {
  ReadMutants({Livox()}, kMutants,
              [](const std::string& bytes) { ReadCloud("livox_ros_driver2/CustomMsg", bytes); });
}

TEST(Fuzz, Image) {
  ReadMutants({RawImage("mono8", 1), RawImage("rgb8", 3), RawImage("bayer_rggb8", 1), RawImage("yuv422", 2),
               RawImage("mono16", 2)},
              kMutants, [](const std::string& bytes) {
                DecodeImage(MessageOf("sensor_msgs/Image", bytes), "/camera");
              });
}

TEST(Fuzz, CompressedImage) {
  ReadMutants({CompressedImage("jpeg"), CompressedImage("png")}, kMutants / 4, [](const std::string& bytes) {
    DecodeImage(MessageOf("sensor_msgs/CompressedImage", bytes), "/camera");
  });
}

TEST(CompressedImage, ClaimsNoMoreThanItsBytesHold) {
  std::string bytes = CompressedImage("png");
  const std::size_t width = bytes.find("IHDR") + 4;
  bytes.replace(width, 8, std::string("\0\0\xea\x60\0\0\xea\x60", 8));
  try {
    DecodeImage(MessageOf("sensor_msgs/CompressedImage", bytes), "/camera");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("damaged (60000 x 60000"), std::string::npos) << error.what();
  }
}

TEST(Fuzz, Imu) {
  sensor_msgs::Imu imu;
  imu.header.frame_id = "imu_link";
  ReadMutants({Serialized(imu)}, kMutants, [](const std::string& bytes) {
    std::string frame;
    DecodeImu(MessageOf("sensor_msgs/Imu", bytes), "/imu", frame);
  });
}

}  // namespace
}  // namespace mlic
