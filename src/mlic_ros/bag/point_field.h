#pragma once

#include <sensor_msgs/PointField.h>

#include <cstdint>
#include <string>

namespace mlic {

// A field of one value in a PointCloud2; type: one of sensor_msgs::PointField's.
inline sensor_msgs::PointField MakeField(const std::string& name, std::uint32_t offset, std::uint8_t type) {
  sensor_msgs::PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = type;
  field.count = 1;
  return field;
}

}  // namespace mlic
