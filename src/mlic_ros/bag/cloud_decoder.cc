#include "mlic_ros/bag/cloud_decoder.h"

#include <algorithm>
#include <cstring>

#include "mlic_core/common/error.h"
#include "mlic_ros/bag/livox_message.h"
#include "mlic_ros/bag/point_cloud_view.h"

namespace mlic {
namespace {

using sensor_msgs::PointField;

constexpr TimeNs kSameClock = 1'000'000'000;  // from: guard, clocks differ by far more or not at all
constexpr const char* kLivoxTimeField = "offset_time";

bool IsLivox(const std::string& type) {
  return type == "livox_ros_driver/CustomMsg" || type == "livox_ros_driver2/CustomMsg";
}

// Calls store(index, value) for the field's value of every point.
template <typename T, typename Store>
void ReadFieldOf(const PointCloudView& cloud, const PointField& field, const Store& store) {
  std::size_t index = 0;
  for (std::size_t row = 0; row < cloud.height; ++row) {
    const std::uint8_t* bytes = cloud.data + row * cloud.row_step + field.offset;
    for (std::size_t column = 0; column < cloud.width; ++column, bytes += cloud.point_step) {
      T value;
      std::memcpy(&value, bytes, sizeof(T));
      store(index++, static_cast<double>(value));
    }
  }
}

template <typename Store>
void ReadField(const PointCloudView& cloud, const PointField& field, const Store& store) {
  switch (field.datatype) {
    case PointField::INT8:
      return ReadFieldOf<std::int8_t>(cloud, field, store);
    case PointField::UINT8:
      return ReadFieldOf<std::uint8_t>(cloud, field, store);
    case PointField::INT16:
      return ReadFieldOf<std::int16_t>(cloud, field, store);
    case PointField::UINT16:
      return ReadFieldOf<std::uint16_t>(cloud, field, store);
    case PointField::INT32:
      return ReadFieldOf<std::int32_t>(cloud, field, store);
    case PointField::UINT32:
      return ReadFieldOf<std::uint32_t>(cloud, field, store);
    case PointField::FLOAT32:
      return ReadFieldOf<float>(cloud, field, store);
    case PointField::FLOAT64:
      return ReadFieldOf<double>(cloud, field, store);
    default:
      throw InternalError("a field of unknown type is read");
  }
}

// Rows of an organised cloud are rings where no field says so; some drivers write it transposed.
void RingsFromShape(const PointCloudView& view, DecodedCloud& cloud) {
  if (view.height < 2 || view.width < 2) return;
  const bool rows = view.height <= view.width;
  for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
    cloud.rings.push_back(static_cast<std::uint16_t>(rows ? i / view.width : i % view.width));
  }
}

DecodedCloud DecodePointCloud2(const SerializedMessage& message, const std::string& topic,
                               const std::vector<std::string>& time_fields) {
  const PointCloudView view = ViewPointCloud(message, topic);
  DecodedCloud cloud;
  cloud.stamp = static_cast<TimeNs>(view.header.stamp.toNSec());
  cloud.frame_id = view.header.frame_id;
  cloud.fields = DescribeFields(view.fields);
  if (view.Count() == 0) return cloud;
  cloud.positions.resize(view.Count());
  const char* axes[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    ReadField(view, *FindField(view, {axes[axis]}),
              [&](std::size_t i, double value) { cloud.positions[i][axis] = static_cast<float>(value); });
  }
  const PointField* intensity = FindField(view, {"intensity", "intensities", "reflectivity", "i"});
  if (intensity != nullptr) {
    cloud.intensities.resize(view.Count());
    ReadField(view, *intensity,
              [&](std::size_t i, double value) { cloud.intensities[i] = static_cast<float>(value); });
  }
  const PointField* ring = FindField(view, {"ring", "channel", "line", "laser_id", "laser", "row"});
  if (ring != nullptr) {
    cloud.rings.resize(view.Count());
    ReadField(view, *ring, [&](std::size_t i, double value) {
      cloud.rings[i] = value >= 0.0 && value <= 65535.0 ? static_cast<std::uint16_t>(value) : 0;
    });
  } else {
    RingsFromShape(view, cloud);
  }
  for (const std::string& name : time_fields) {
    const PointField* time = FindField(view, {name});
    if (time == nullptr) continue;
    cloud.times.push_back({name, std::vector<double>(view.Count())});
    std::vector<double>& values = cloud.times.back().values;
    ReadField(view, *time, [&](std::size_t i, double value) { values[i] = value; });
  }
  return cloud;
}

DecodedCloud DecodeLivox(const SerializedMessage& bytes, const std::string& topic,
                         const std::vector<std::string>& time_fields) {
  const LivoxMessage message = ReadLivoxMessage(bytes, topic);
  DecodedCloud cloud;
  cloud.stamp = static_cast<TimeNs>(message.header.stamp.toNSec());
  cloud.frame_id = message.header.frame_id;
  cloud.fields = "x y z f32, reflectivity tag line u8, offset_time u32";
  const TimeNs time_base = static_cast<TimeNs>(message.timebase);
  cloud.time_base_in_other_clock =
      time_base < cloud.stamp - kSameClock || time_base > cloud.stamp + kSameClock;
  if (!cloud.time_base_in_other_clock) cloud.stamp = time_base;
  std::vector<double> times;
  for (const LivoxPoint& point : message.points) {
    cloud.positions.emplace_back(point.x, point.y, point.z);
    cloud.intensities.push_back(point.reflectivity);
    cloud.rings.push_back(point.line);
    times.push_back(point.offset_time);
  }
  if (std::find(time_fields.begin(), time_fields.end(), kLivoxTimeField) != time_fields.end()) {
    cloud.times.push_back({kLivoxTimeField, std::move(times)});
  }
  return cloud;
}

}  // namespace

bool IsLidarType(const std::string& type) { return type == "sensor_msgs/PointCloud2" || IsLivox(type); }

bool IsRawLidarType(const std::string& type) {
  const std::string scan = "Scan";
  const bool ends_in_scan =
      type.size() > scan.size() && type.compare(type.size() - scan.size(), std::string::npos, scan) == 0;
  // The package sensor_msgs has scans of planar LiDARs, which are no packets.
  return type.rfind("sensor_msgs/", 0) != 0 && (ends_in_scan || type.find("Packet") != std::string::npos);
}

const std::vector<std::string>& PointTimeFieldNames() {
  static const std::vector<std::string> names{"time", "t", "timestamp", kLivoxTimeField, "time_stamp"};
  return names;
}

DecodedCloud DecodeCloud(const SerializedMessage& message, const std::string& topic,
                         const std::vector<std::string>& time_fields) {
  DecodedCloud cloud = IsLivox(message.type) ? DecodeLivox(message, topic, time_fields)
                                             : DecodePointCloud2(message, topic, time_fields);
  cloud.record_time = message.record_time;
  return cloud;
}

std::string FaultOfCloud(const SerializedMessage& message, const std::string& topic) {
  try {
    if (IsLivox(message.type)) {
      ReadLivoxMessage(message, topic);
    } else {
      ViewPointCloud(message, topic);
    }
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

}  // namespace mlic
