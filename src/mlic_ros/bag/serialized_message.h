#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mlic_core/common/time.h"

namespace mlic {

// A message as it came off the bag, not yet deserialised.
struct SerializedMessage {
  std::string type;  // such as sensor_msgs/PointCloud2
  std::vector<std::uint8_t> bytes;
  TimeNs record_time = 0;
};

}  // namespace mlic
