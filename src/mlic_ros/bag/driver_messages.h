#pragma once

#include <sensor_msgs/PointCloud2.h>

#include "mlic_ros/bag/livox_message.h"
#include "mlic_sim/simulation.h"

namespace mlic {

// A simulated scan in the words of a LiDAR driver (see sim::PointLayout). Header stamps and absolute point
// times are on the LiDAR's clock.
sensor_msgs::PointCloud2 MakePointCloud(const sim::SimulatedLidar& lidar, const sim::SimulatedScan& scan);

// Beams without return are points at the origin. Header stamp and timebase are the scan's start.
LivoxMessage MakeLivoxMessage(const sim::SimulatedLidar& lidar, const sim::SimulatedScan& scan);

}  // namespace mlic

namespace ros::message_traits {

template <>
struct IsMessage<mlic::LivoxMessage> : TrueType {};

template <>
struct MD5Sum<mlic::LivoxMessage> {
  static const char* value() { return "e4d6829bdfe657cb6c21a746c86b21a6"; }
  static const char* value(const mlic::LivoxMessage&) { return value(); }
};

template <>
struct DataType<mlic::LivoxMessage> {
  static const char* value() { return "livox_ros_driver/CustomMsg"; }
  static const char* value(const mlic::LivoxMessage&) { return value(); }
};

// The message's fields and those of the messages within, as rosbag and rostopic expect them.
template <>
struct Definition<mlic::LivoxMessage> {
  static const char* value();
  static const char* value(const mlic::LivoxMessage&) { return value(); }
};

}  // namespace ros::message_traits
