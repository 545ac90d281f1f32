#include "mlic_ros/bag/point_cloud_view.h"

#include <stdexcept>

#include "mlic_core/common/error.h"
#include "mlic_core/common/printable.h"
#include "mlic_ros/bag/message_stream.h"

namespace mlic {
namespace {

using sensor_msgs::PointField;

const char* NameOfType(std::uint8_t datatype) {
  constexpr const char* names[] = {"?", "i8", "u8", "i16", "u16", "i32", "u32", "f32", "f64"};
  return datatype <= PointField::FLOAT64 ? names[datatype] : names[0];
}

// Of a serialised PointField: length of name, offset, type, count; from: standard.
constexpr std::size_t kLeastFieldBytes = 13;

PointCloudView Parse(const SerializedMessage& message) {
  ros::serialization::IStream stream = StreamOf(message);
  PointCloudView cloud;
  stream.next(cloud.header);
  std::uint32_t height = 0, width = 0, fields = 0, point_step = 0, row_step = 0, size = 0;
  std::uint8_t big_endian = 0;
  stream.next(height);
  stream.next(width);
  stream.next(fields);
  if (fields > stream.getLength() / kLeastFieldBytes) throw std::out_of_range("fields");
  cloud.fields.resize(fields);
  for (PointField& field : cloud.fields) stream.next(field);
  stream.next(big_endian);
  stream.next(point_step);
  stream.next(row_step);
  stream.next(size);
  cloud.data = stream.advance(size);
  cloud.height = height;
  cloud.width = width;
  cloud.point_step = point_step;
  cloud.row_step = row_step;
  cloud.big_endian = big_endian != 0;
  cloud.size = size;
  return cloud;
}

void CheckSizes(const PointCloudView& cloud, const std::string& topic) {
  const std::size_t row = cloud.width * cloud.point_step;  // both below 2^32
  const bool fits = cloud.point_step > 0 && cloud.width <= cloud.size / cloud.point_step &&
                    cloud.row_step >= row && cloud.size >= row &&
                    (cloud.size - row) / cloud.row_step >= cloud.height - 1;
  if (fits) return;
  throw InputError("topic " + topic + ": the sizes of a point cloud do not fit together (" +
                   std::to_string(cloud.size) + " bytes for " + std::to_string(cloud.height) + " rows of " +
                   std::to_string(cloud.row_step) + " bytes and " + std::to_string(cloud.width) +
                   " points of " + std::to_string(cloud.point_step) + "); the driver is at fault");
}

void CheckFields(const PointCloudView& cloud, const std::string& topic) {
  for (const PointField& field : cloud.fields) {
    const std::size_t size = SizeOfType(field.datatype);
    if (size > 0 && field.offset + size > cloud.point_step) {
      throw InputError("topic " + topic + ": field '" + Printable(field.name) + "' at byte " +
                       std::to_string(field.offset) + " does not fit into points of " +
                       std::to_string(cloud.point_step) + " bytes; the driver is at fault");
    }
  }
  for (const char* axis : {"x", "y", "z"}) {
    if (FindField(cloud, {axis}) == nullptr) {
      throw InputError("topic " + topic + ": a point cloud without field '" + axis + "' (it has " +
                       DescribeFields(cloud.fields) + "); expected at least x, y and z");
    }
  }
}

}  // namespace

std::string DescribeFields(const std::vector<PointField>& fields) {
  std::string text;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    text += (text.empty() ? "" : " ") + Printable(fields[i].name);
    const bool last = i + 1 == fields.size();
    if (last || fields[i + 1].datatype != fields[i].datatype) {
      text += std::string(" ") + NameOfType(fields[i].datatype) + (last ? "" : ",");
    }
  }
  return text.empty() ? "no fields" : text;
}

std::size_t SizeOfType(std::uint8_t datatype) {
  switch (datatype) {
    case PointField::INT8:
    case PointField::UINT8:
      return 1;
    case PointField::INT16:
    case PointField::UINT16:
      return 2;
    case PointField::INT32:
    case PointField::UINT32:
    case PointField::FLOAT32:
      return 4;
    case PointField::FLOAT64:
      return 8;
    default:
      return 0;
  }
}

const PointField* FindField(const PointCloudView& cloud, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    for (const PointField& field : cloud.fields) {
      if (field.name == name && SizeOfType(field.datatype) > 0) return &field;
    }
  }
  return nullptr;
}

PointCloudView ViewPointCloud(const SerializedMessage& message, const std::string& topic) {
  PointCloudView cloud;
  try {
    cloud = Parse(message);
  } catch (const std::exception&) {
    throw InputError("topic " + topic + ": a message of type " + message.type +
                     " is cut off or has another layout than its type says; record it again");
  }
  if (cloud.width == 0 || cloud.height == 0) {
    cloud.width = cloud.height = 0;
    return cloud;
  }
  if (cloud.row_step == 0 || cloud.height == 1) cloud.row_step = cloud.width * cloud.point_step;
  CheckSizes(cloud, topic);
  if (cloud.big_endian) {
    throw InputError("topic " + topic + ": the point cloud is big-endian; expected little-endian data");
  }
  CheckFields(cloud, topic);
  return cloud;
}

}  // namespace mlic
