#include "fuzz/ros_targets.h"

#include <stdexcept>

#include "mlic_core/common/error.h"
#include "mlic_ros/bag/cloud_decoder.h"
#include "mlic_ros/bag/image_reader.h"
#include "mlic_ros/bag/imu_messages.h"

namespace mlic {
namespace {

SerializedMessage MessageOf(const std::string& type, const std::string& bytes) {
  return {type, std::vector<std::uint8_t>(bytes.begin(), bytes.end()), 1600000000000000000};
}

void ReadCloud(const std::string& type, const std::string& bytes) {
  const SerializedMessage message = MessageOf(type, bytes);
  const bool sound = FaultOfCloud(message, "/points").empty();
  bool decoded = false;
  try {
    DecodeCloud(message, "/points", PointTimeFieldNames());
    decoded = true;
  } catch (const InputError&) {
    if (!sound) throw;
  }
  if (sound != decoded) throw std::logic_error("FaultOfCloud and DecodeCloud disagree");
}

}  // namespace

void FuzzPointCloud2(const std::string& bytes) { ReadCloud("sensor_msgs/PointCloud2", bytes); }
void FuzzLivox(const std::string& bytes) { ReadCloud("livox_ros_driver2/CustomMsg", bytes); }
void FuzzImage(const std::string& bytes) { DecodeImage(MessageOf("sensor_msgs/Image", bytes), "/camera"); }
void FuzzCompressedImage(const std::string& bytes) {
  DecodeImage(MessageOf("sensor_msgs/CompressedImage", bytes), "/camera");
}
void FuzzImu(const std::string& bytes) {
  std::string frame;
  DecodeImu(MessageOf("sensor_msgs/Imu", bytes), "/imu", frame);
}

}  // namespace mlic
