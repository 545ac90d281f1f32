#pragma once

#include <string>

#include "mlic_core/ingest/stamped_imu.h"
#include "mlic_ros/bag/serialized_message.h"

namespace mlic {

bool IsImuType(const std::string& type);

// Reads a sensor_msgs/Imu. Throws InputError, one line that starts with the topic, when it is cut off.
StampedImu DecodeImu(const SerializedMessage& message, const std::string& topic, std::string& frame_id);

}  // namespace mlic
