#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "mlic_core/common/time.h"

namespace mlic {

// A LiDAR message as it came off the bag, not yet deserialised.
struct RawCloud {
  std::string type;  // sensor_msgs/PointCloud2, livox_ros_driver/CustomMsg or livox_ros_driver2/CustomMsg
  std::vector<std::uint8_t> bytes;
  TimeNs record_time = 0;
};

// The points of a message in its order, whatever the driver's layout. All vectors have the same length, or
// are empty when the message has no such field.
struct DecodedCloud {
  TimeNs stamp = 0;  // header stamp; for the Livox message its timebase, if that runs in the same clock
  std::string frame_id;
  std::vector<Eigen::Vector3f> positions;  // m; not finite or zero where there was no return
  std::vector<float> intensities;
  std::vector<std::uint16_t> rings;
  std::vector<double> times;  // raw values of the time field
  bool time_base_in_other_clock =
      false;  // Livox: timebase is far from the header stamp, which is used instead
};

// Field names and types, for reports, such as "x y z intensity f32, ring u16, time f32".
std::string DescribeFields(const RawCloud& cloud);

// The fields that may hold point times, in the order in which they are to be tried.
std::vector<std::string> TimeFields(const RawCloud& cloud);

bool IsLidarType(const std::string& type);

// Reads the whole message; times from field time_field (empty: none). Throws InputError, starting with the
// topic, for messages without x, y, z or whose sizes do not fit together.
DecodedCloud DecodeCloud(const RawCloud& cloud, const std::string& topic, const std::string& time_field);

}  // namespace mlic
