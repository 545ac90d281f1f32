#include "mlic_ros/bag/cloud_decoder.h"

#include <ros/serialization.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstring>
#include <map>

#include "mlic_core/common/error.h"
#include "mlic_ros/bag/livox_message.h"

namespace mlic {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

constexpr const char* kPointCloud2 = "sensor_msgs/PointCloud2";
constexpr TimeNs kSameClock = 1'000'000'000;  // from: guard, clocks differ by far more or not at all

bool IsLivox(const std::string& type) {
  return type == "livox_ros_driver/CustomMsg" || type == "livox_ros_driver2/CustomMsg";
}

template <typename Message>
Message Deserialize(const RawCloud& cloud, const std::string& topic) {
  try {
    // The stream only reads, but its interface takes a pointer to non-const.
    ros::serialization::IStream stream(const_cast<std::uint8_t*>(cloud.bytes.data()),
                                       static_cast<std::uint32_t>(cloud.bytes.size()));
    Message message;
    ros::serialization::deserialize(stream, message);
    return message;
  } catch (const std::exception&) {
    throw InputError("topic " + topic + ": a message of type " + cloud.type +
                     " is cut off or has another layout than its type says; record it again");
  }
}

struct FieldType {
  std::size_t size;
  const char* name;
  double (*read)(const std::uint8_t*);
};

template <typename T>
double ReadAs(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

const FieldType* FieldTypeOf(std::uint8_t datatype) {
  static const std::map<std::uint8_t, FieldType> types{
      {PointField::INT8, {1, "i8", ReadAs<std::int8_t>}},
      {PointField::UINT8, {1, "u8", ReadAs<std::uint8_t>}},
      {PointField::INT16, {2, "i16", ReadAs<std::int16_t>}},
      {PointField::UINT16, {2, "u16", ReadAs<std::uint16_t>}},
      {PointField::INT32, {4, "i32", ReadAs<std::int32_t>}},
      {PointField::UINT32, {4, "u32", ReadAs<std::uint32_t>}},
      {PointField::FLOAT32, {4, "f32", ReadAs<float>}},
      {PointField::FLOAT64, {8, "f64", ReadAs<double>}},
  };
  const auto found = types.find(datatype);
  return found == types.end() ? nullptr : &found->second;
}

const PointField* FindField(const PointCloud2& message, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    for (const PointField& field : message.fields) {
      if (field.name == name) return &field;
    }
  }
  return nullptr;
}

void CheckSizes(const PointCloud2& message, const std::string& topic) {
  const std::size_t rows = static_cast<std::size_t>(message.row_step) * message.height;
  const bool fits = message.data.size() >= rows &&
                    static_cast<std::size_t>(message.point_step) * message.width <= message.row_step;
  if (!fits && message.width > 0) {
    throw InputError("topic " + topic + ": the sizes of a point cloud do not fit together (" +
                     std::to_string(message.data.size()) + " bytes for " + std::to_string(message.height) +
                     " rows of " + std::to_string(message.row_step) + " bytes and " +
                     std::to_string(message.width) + " points of " + std::to_string(message.point_step) +
                     "); the driver is at fault");
  }
  if (message.is_bigendian) {
    throw InputError("topic " + topic + ": the point cloud is big-endian; expected little-endian data");
  }
  for (const PointField& field : message.fields) {
    const FieldType* type = FieldTypeOf(field.datatype);
    if (type != nullptr && field.offset + type->size > message.point_step) {
      throw InputError("topic " + topic + ": field '" + field.name + "' at byte " +
                       std::to_string(field.offset) + " does not fit into points of " +
                       std::to_string(message.point_step) + " bytes; the driver is at fault");
    }
  }
}

// Calls store(index, value) for the field's value of every point.
template <typename Store>
void ReadField(const PointCloud2& message, const PointField& field, const Store& store) {
  const FieldType* type = FieldTypeOf(field.datatype);
  std::size_t index = 0;
  for (std::size_t row = 0; row < message.height; ++row) {
    const std::uint8_t* bytes = message.data.data() + row * message.row_step + field.offset;
    for (std::size_t column = 0; column < message.width; ++column, bytes += message.point_step) {
      store(index++, type->read(bytes));
    }
  }
}

// Rows of an organised cloud are rings where no field says so; some drivers write it transposed.
void RingsFromShape(const PointCloud2& message, DecodedCloud& cloud) {
  if (message.height < 2 || message.width < 2) return;
  const bool rows = message.height <= message.width;
  for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
    cloud.rings.push_back(static_cast<std::uint16_t>(rows ? i / message.width : i % message.width));
  }
}

DecodedCloud DecodePointCloud2(const RawCloud& raw, const std::string& topic, const std::string& time_field) {
  const PointCloud2 message = Deserialize<PointCloud2>(raw, topic);
  CheckSizes(message, topic);
  DecodedCloud cloud;
  cloud.stamp = static_cast<TimeNs>(message.header.stamp.toNSec());
  cloud.frame_id = message.header.frame_id;
  const std::size_t count = static_cast<std::size_t>(message.width) * message.height;
  cloud.positions.resize(count);
  const char* axes[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const PointField* field = FindField(message, {axes[axis]});
    if (field == nullptr || FieldTypeOf(field->datatype) == nullptr) {
      throw InputError("topic " + topic + ": a point cloud without field '" + axes[axis] + "' (it has " +
                       DescribeFields(raw) + "); expected at least x, y and z");
    }
    ReadField(message, *field,
              [&](std::size_t i, double value) { cloud.positions[i][axis] = static_cast<float>(value); });
  }
  const PointField* intensity = FindField(message, {"intensity", "intensities", "reflectivity", "i"});
  if (intensity != nullptr && FieldTypeOf(intensity->datatype) != nullptr) {
    cloud.intensities.resize(count);
    ReadField(message, *intensity,
              [&](std::size_t i, double value) { cloud.intensities[i] = static_cast<float>(value); });
  }
  const PointField* ring = FindField(message, {"ring", "channel", "line", "laser_id", "laser", "row"});
  if (ring != nullptr && FieldTypeOf(ring->datatype) != nullptr) {
    cloud.rings.resize(count);
    ReadField(message, *ring, [&](std::size_t i, double value) {
      cloud.rings[i] = value >= 0.0 && value <= 65535.0 ? static_cast<std::uint16_t>(value) : 0;
    });
  } else {
    RingsFromShape(message, cloud);
  }
  if (!time_field.empty()) {
    const PointField* time = FindField(message, {time_field});
    if (time == nullptr || FieldTypeOf(time->datatype) == nullptr) {
      throw InputError("topic " + topic + ": field '" + time_field + "' is missing in some messages (" +
                       DescribeFields(raw) + "); expected the same fields in all");
    }
    cloud.times.resize(count);
    ReadField(message, *time, [&](std::size_t i, double value) { cloud.times[i] = value; });
  }
  return cloud;
}

DecodedCloud DecodeLivox(const RawCloud& raw, const std::string& topic) {
  const LivoxMessage message = Deserialize<LivoxMessage>(raw, topic);
  DecodedCloud cloud;
  cloud.stamp = static_cast<TimeNs>(message.header.stamp.toNSec());
  cloud.frame_id = message.header.frame_id;
  const TimeNs time_base = static_cast<TimeNs>(message.timebase);
  cloud.time_base_in_other_clock = std::llabs(time_base - cloud.stamp) > kSameClock;
  if (!cloud.time_base_in_other_clock) cloud.stamp = time_base;
  for (const LivoxPoint& point : message.points) {
    cloud.positions.emplace_back(point.x, point.y, point.z);
    cloud.intensities.push_back(point.reflectivity);
    cloud.rings.push_back(point.line);
    cloud.times.push_back(point.offset_time);
  }
  return cloud;
}

}  // namespace

bool IsLidarType(const std::string& type) { return type == kPointCloud2 || IsLivox(type); }

std::string DescribeFields(const RawCloud& cloud) {
  if (IsLivox(cloud.type)) return "x y z f32, reflectivity tag line u8, offset_time u32";
  const PointCloud2 message = Deserialize<PointCloud2>(cloud, "");
  std::string text;
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    const PointField& field = message.fields[i];
    const FieldType* type = FieldTypeOf(field.datatype);
    text += (text.empty() ? "" : " ") + field.name;
    const bool last = i + 1 == message.fields.size();
    if (last || message.fields[i + 1].datatype != field.datatype) {
      text += std::string(" ") + (type == nullptr ? "?" : type->name) + (last ? "" : ",");
    }
  }
  return text.empty() ? "no fields" : text;
}

std::vector<std::string> TimeFields(const RawCloud& cloud) {
  if (IsLivox(cloud.type)) return {"offset_time"};
  const PointCloud2 message = Deserialize<PointCloud2>(cloud, "");
  std::vector<std::string> names;
  for (const char* name : {"time", "t", "timestamp", "offset_time", "time_stamp"}) {
    const PointField* field = FindField(message, {name});
    if (field != nullptr && FieldTypeOf(field->datatype) != nullptr) names.push_back(name);
  }
  return names;
}

DecodedCloud DecodeCloud(const RawCloud& cloud, const std::string& topic, const std::string& time_field) {
  return IsLivox(cloud.type) ? DecodeLivox(cloud, topic) : DecodePointCloud2(cloud, topic, time_field);
}

}  // namespace mlic
