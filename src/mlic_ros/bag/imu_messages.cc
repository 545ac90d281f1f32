#include "mlic_ros/bag/imu_messages.h"

#include <sensor_msgs/Imu.h>

#include "mlic_core/common/error.h"
#include "mlic_ros/bag/message_stream.h"

namespace mlic {

bool IsImuType(const std::string& type) { return type == "sensor_msgs/Imu"; }

StampedImu DecodeImu(const SerializedMessage& message, const std::string& topic, std::string& frame_id) {
  sensor_msgs::Imu imu;
  try {
    ros::serialization::IStream stream = StreamOf(message);
    ros::serialization::deserialize(stream, imu);
  } catch (const std::exception&) {
    throw InputError("topic " + topic + ": an IMU message is cut off; record it again");
  }
  frame_id = imu.header.frame_id;
  return {static_cast<TimeNs>(imu.header.stamp.toNSec()),
          message.record_time,
          {imu.angular_velocity.x, imu.angular_velocity.y, imu.angular_velocity.z},
          {imu.linear_acceleration.x, imu.linear_acceleration.y, imu.linear_acceleration.z}};
}

}  // namespace mlic
