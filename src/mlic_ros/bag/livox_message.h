#pragma once

#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <string>
#include <vector>

#include "mlic_ros/bag/serialized_message.h"

namespace mlic {

// livox_ros_driver/CustomMsg and livox_ros_driver2/CustomMsg (same layout), so that no driver package is
// needed.
struct LivoxPoint {
  std::uint32_t offset_time;  // ns after the timebase
  float x, y, z;              // m
  std::uint8_t reflectivity, tag, line;
};

struct LivoxMessage {
  std_msgs::Header header;
  std::uint64_t timebase;  // ns
  std::uint32_t point_num;
  std::uint8_t lidar_id;
  std::uint8_t reserved[3];
  std::vector<LivoxPoint> points;
};

// Checks the number of points against the message's bytes before it takes memory for them. Throws InputError,
// one line that starts with the topic, for a message that is cut off.
LivoxMessage ReadLivoxMessage(const SerializedMessage& message, const std::string& topic);

}  // namespace mlic

namespace ros::serialization {

template <>
struct Serializer<mlic::LivoxPoint> {
  template <typename Stream, typename Point>
  static void allInOne(Stream& stream, Point point) {
    stream.next(point.offset_time);
    stream.next(point.x);
    stream.next(point.y);
    stream.next(point.z);
    stream.next(point.reflectivity);
    stream.next(point.tag);
    stream.next(point.line);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<mlic::LivoxMessage> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message message) {
    stream.next(message.header);
    stream.next(message.timebase);
    stream.next(message.point_num);
    stream.next(message.lidar_id);
    for (auto& byte : message.reserved) stream.next(byte);
    stream.next(message.points);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace ros::serialization
