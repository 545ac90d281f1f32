#pragma once

#include <sensor_msgs/PointField.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <string>
#include <vector>

#include "mlic_ros/bag/serialized_message.h"

namespace mlic {

// A sensor_msgs/PointCloud2 whose points stay in the message that it was read from.
struct PointCloudView {
  std_msgs::Header header;
  std::vector<sensor_msgs::PointField> fields;
  std::size_t height = 0, width = 0;
  std::size_t point_step = 0, row_step = 0;  // bytes
  bool big_endian = false;
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;  // bytes of data

  std::size_t Count() const { return height * width; }
};

// Field names and types, for reports, such as "x y z intensity f32, ring u16, time f32".
std::string DescribeFields(const std::vector<sensor_msgs::PointField>& fields);

// Bytes of one value of a PointField's datatype; 0 for a type that there is none of.
std::size_t SizeOfType(std::uint8_t datatype);

// The first field of the names, in their order, whose type is known; nullptr for none.
const sensor_msgs::PointField* FindField(const PointCloudView& cloud, const std::vector<std::string>& names);

// Reads the message without taking memory for its points, and checks that every point of width x height lies
// within the data and every field within a point, and that there are x, y and z (unless there are no points).
// A row_step of 0, or of a single row, is repaired. Throws InputError, one line that starts with the topic.
PointCloudView ViewPointCloud(const SerializedMessage& message, const std::string& topic);

}  // namespace mlic
