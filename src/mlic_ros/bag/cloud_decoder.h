#pragma once

#include <sensor_msgs/PointField.h>

#include <string>
#include <vector>

#include "mlic_core/ingest/decoded_cloud.h"
#include "mlic_ros/bag/serialized_message.h"

namespace mlic {

// sensor_msgs/PointCloud2, livox_ros_driver/CustomMsg or livox_ros_driver2/CustomMsg.
bool IsLidarType(const std::string& type);

// Whether a type of message is one of drivers, which holds what a LiDAR sends before it is made a cloud, as
// velodyne_msgs/VelodyneScan and ouster_ros/PacketMsg; and what to do then, for people.
bool IsRawLidarType(const std::string& type);
constexpr const char* kRawLidarRemedy =
    "play the bag through the driver's node that makes clouds of it and record sensor_msgs/PointCloud2";

// The fields that may hold point times, in the order in which they are to be tried.
const std::vector<std::string>& PointTimeFieldNames();

// Reads a LiDAR message, with those of the named time fields that it has. Fields are read one by one: drivers
// differ in their names, types and offsets, and pcl_conversions takes only those that agree with a point
// type. Throws InputError, one line that starts with the topic, for messages that are cut off, without x, y,
// z, or whose sizes do not fit together; takes no more memory than the message's own bytes can fill.
DecodedCloud DecodeCloud(const SerializedMessage& message, const std::string& topic,
                         const std::vector<std::string>& time_fields);

// The error that DecodeCloud would throw, found without reading the points; empty: none.
std::string FaultOfCloud(const SerializedMessage& message, const std::string& topic);

}  // namespace mlic
