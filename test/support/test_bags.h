#pragma once

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/PointField.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/common/time.h"
#include "mlic_ros/bag/livox_message.h"

namespace mlic {
// As the second driver names it.
struct Livox2Message : LivoxMessage {};
}  // namespace mlic

namespace ros::message_traits {

template <>
struct IsMessage<mlic::Livox2Message> : TrueType {};
template <>
struct MD5Sum<mlic::Livox2Message> {
  static const char* value() { return "e4d6829bdfe657cb6c21a746c86b21a6"; }
  static const char* value(const mlic::Livox2Message&) { return value(); }
};
template <>
struct DataType<mlic::Livox2Message> {
  static const char* value() { return "livox_ros_driver2/CustomMsg"; }
  static const char* value(const mlic::Livox2Message&) { return value(); }
};
template <>
struct Definition<mlic::Livox2Message> {
  static const char* value() { return "# not needed to read it\n"; }
  static const char* value(const mlic::Livox2Message&) { return value(); }
};

}  // namespace ros::message_traits

namespace ros::serialization {

template <>
struct Serializer<mlic::Livox2Message> : Serializer<mlic::LivoxMessage> {};

}  // namespace ros::serialization

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

constexpr TimeNs kBagStart = 1'700'000'000'000'000'000;
constexpr double kScanPeriod = 0.1;
constexpr int kColumns = 360, kRings = 4;

inline ros::Time RosTimeAt(TimeNs time) {
  ros::Time result;
  result.fromNSec(static_cast<std::uint64_t>(time));
  return result;
}

// How the points of a test bag are laid out.
enum class Layout {
  kSeconds,              // f32 `time` after the stamp
  kNanoseconds,          // u32 `t` after the stamp
  kAbsoluteSeconds,      // f64 `timestamp`
  kAbsoluteNanoseconds,  // f64 `timestamp`
  kBeforeStamp,          // f32 `time`, negative: the stamp is at the end
  kOtherClock,           // f64 `timestamp` since the sensor was switched on
  kZeroTimes,            // f32 `time`, never set
  kNoTimes,
};

// What to write; the hooks change or drop single messages.
struct TestBag {
  std::string path;
  TimeNs start = kBagStart;
  double seconds = 3.0;
  Layout layout = Layout::kSeconds;
  bool with_imu = true, with_lidar = true, livox = false;
  std::function<bool(int index, sensor_msgs::Imu&)> on_imu;            // false: left out
  std::function<bool(int index, sensor_msgs::PointCloud2&)> on_cloud;  // false: left out
  std::function<void(rosbag::Bag&)> write_more;                        // other topics
};

template <typename T>
void Put(std::vector<std::uint8_t>& data, std::size_t at, T value) {
  std::memcpy(data.data() + at, &value, sizeof(T));
}

// Position of a return: on a cylinder of 10 m with a cone of rings, so that thinning keeps nearly all.
inline Eigen::Vector3f TestPoint(int column, int ring, double view) {
  const double azimuth = view * column / kColumns - 0.5 * view;
  return Eigen::Vector3d(20.0 * std::cos(azimuth), 20.0 * std::sin(azimuth), 1.0 * ring).cast<float>();
}

inline double TestTime(int column) { return kScanPeriod * column / kColumns; }

// Fields x y z intensity f32, ring u16, time (f32, u32 or f64) in steps of 32 bytes; start: of the scan.
inline sensor_msgs::PointCloud2 MakeTestCloud(const TestBag& bag, TimeNs start) {
  using sensor_msgs::PointField;
  sensor_msgs::PointCloud2 cloud;
  const bool before = bag.layout == Layout::kBeforeStamp;
  const TimeNs stamp = before ? TimeFrom(start, kScanPeriod) : start;
  cloud.header.stamp = RosTimeAt(stamp);
  cloud.header.frame_id = "lidar_frame";
  cloud.height = 1;
  cloud.width = kColumns * kRings;
  cloud.point_step = 32;
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.fields = {MakeField("x", 0, PointField::FLOAT32), MakeField("y", 4, PointField::FLOAT32),
                  MakeField("z", 8, PointField::FLOAT32), MakeField("intensity", 12, PointField::FLOAT32),
                  MakeField("ring", 16, PointField::UINT16)};
  const bool absolute = bag.layout == Layout::kAbsoluteSeconds ||
                        bag.layout == Layout::kAbsoluteNanoseconds || bag.layout == Layout::kOtherClock;
  if (absolute) {
    cloud.fields.push_back(MakeField("timestamp", 24, PointField::FLOAT64));
  } else if (bag.layout == Layout::kNanoseconds) {
    cloud.fields.push_back(MakeField("t", 24, PointField::UINT32));
  } else if (bag.layout != Layout::kNoTimes) {
    cloud.fields.push_back(MakeField("time", 24, PointField::FLOAT32));
  }
  cloud.data.resize(cloud.row_step);
  for (int i = 0; i < kColumns * kRings; ++i) {
    const int column = i / kRings, ring = i % kRings;
    const std::size_t at = static_cast<std::size_t>(i) * cloud.point_step;
    const Eigen::Vector3f p = TestPoint(column, ring, 2.0 * M_PI);
    for (int axis = 0; axis < 3; ++axis) Put<float>(cloud.data, at + 4 * axis, p[axis]);
    Put<float>(cloud.data, at + 12, static_cast<float>(column));
    Put<std::uint16_t>(cloud.data, at + 16, static_cast<std::uint16_t>(ring));
    const double t = TestTime(column);
    const double seconds = 1e-9 * static_cast<double>(TimeFrom(start, t));
    switch (bag.layout) {
      case Layout::kSeconds:
        Put<float>(cloud.data, at + 24, static_cast<float>(t));
        break;
      case Layout::kNanoseconds:
        Put<std::uint32_t>(cloud.data, at + 24, static_cast<std::uint32_t>(t * 1e9));
        break;
      case Layout::kAbsoluteSeconds:
        Put<double>(cloud.data, at + 24, seconds);
        break;
      case Layout::kAbsoluteNanoseconds:
        Put<double>(cloud.data, at + 24, seconds * 1e9);
        break;
      case Layout::kBeforeStamp:
        Put<float>(cloud.data, at + 24, static_cast<float>(t - kScanPeriod));
        break;
      case Layout::kOtherClock:
        Put<double>(cloud.data, at + 24, seconds - 1.69e9);
        break;
      case Layout::kZeroTimes:
      case Layout::kNoTimes:
        break;
    }
  }
  return cloud;
}

inline Livox2Message MakeTestLivox(TimeNs start) {
  Livox2Message message{};
  message.header.stamp = RosTimeAt(start);
  message.header.frame_id = "livox_frame";
  message.timebase = static_cast<std::uint64_t>(start);
  for (int i = 0; i < kColumns * kRings; ++i) {
    const Eigen::Vector3f p = TestPoint(i / kRings, i % kRings, 1.2);
    message.points.push_back({static_cast<std::uint32_t>(1e9 * TestTime(i / kRings)), p.x(), p.y(), p.z(), 77,
                              16, static_cast<std::uint8_t>(i % kRings)});
  }
  message.point_num = static_cast<std::uint32_t>(message.points.size());
  return message;
}

// IMU at 100 Hz on /imu, at rest with z up; LiDAR at 10 Hz on /points, recorded at the end of each scan.
inline void WriteTestBag(const TestBag& recipe) {
  rosbag::Bag bag(recipe.path, rosbag::bagmode::Write);
  for (int i = 0; recipe.with_imu && i < static_cast<int>(recipe.seconds * 100.0); ++i) {
    sensor_msgs::Imu imu;
    const TimeNs time = recipe.start + TimeNs{i} * 10'000'000;
    imu.header.stamp = RosTimeAt(time);
    imu.header.frame_id = "imu_frame";
    imu.linear_acceleration.z = 9.81;
    imu.angular_velocity.x = 0.1;
    if (!recipe.on_imu || recipe.on_imu(i, imu)) bag.write("/imu", RosTimeAt(time), imu);
  }
  for (int i = 0; recipe.with_lidar && i < static_cast<int>(recipe.seconds / kScanPeriod); ++i) {
    const TimeNs start = recipe.start + TimeNs{i} * 100'000'000;
    const ros::Time record = RosTimeAt(TimeFrom(start, kScanPeriod));
    if (recipe.livox) {
      bag.write("/points", record, MakeTestLivox(start));
      continue;
    }
    sensor_msgs::PointCloud2 cloud = MakeTestCloud(recipe, start);
    if (!recipe.on_cloud || recipe.on_cloud(i, cloud)) bag.write("/points", record, cloud);
  }
  if (recipe.write_more) recipe.write_more(bag);
}

// Expects an InputError of one line with all the parts.
inline void ExpectInputError(const std::function<void()>& load, const std::vector<std::string>& parts) {
  try {
    load();
    FAIL() << "loaded without an error";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    for (const std::string& part : parts)
      EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
  }
}

inline bool Reported(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

}  // namespace mlic
