#include "mlic_ros/bag/driver_messages.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

using sensor_msgs::PointField;
using sim::PointLayout;

enum class Content { kX, kY, kZ, kIntensity, kRing, kTime, kRangeMillimetres, kZero };

struct Field {
  const char* name;
  std::uint8_t type;
  std::uint32_t offset;
  Content content;
};

// What becomes of beams without return.
enum class Missing { kRejected, kZero, kNan };

struct CloudLayout {
  std::vector<Field> fields;
  std::uint32_t point_step;
  Missing missing;
  bool ring_major;  // organised: one row for each ring
};

const CloudLayout& LayoutOf(PointLayout layout) {
  constexpr auto f32 = PointField::FLOAT32;
  constexpr auto f64 = PointField::FLOAT64;
  constexpr auto u16 = PointField::UINT16;
  constexpr auto u32 = PointField::UINT32;
  static const Field x{"x", f32, 0, Content::kX}, y{"y", f32, 4, Content::kY}, z{"z", f32, 8, Content::kZ};
  static const CloudLayout velodyne{{x,
                                     y,
                                     z,
                                     {"intensity", f32, 12, Content::kIntensity},
                                     {"ring", u16, 16, Content::kRing},
                                     {"time", f32, 18, Content::kTime}},
                                    22,
                                    Missing::kRejected,
                                    false};
  static const CloudLayout ouster{{x,
                                   y,
                                   z,
                                   {"intensity", f32, 16, Content::kIntensity},
                                   {"t", u32, 20, Content::kTime},
                                   {"reflectivity", u16, 24, Content::kZero},
                                   {"ring", u16, 26, Content::kRing},
                                   {"ambient", u16, 28, Content::kZero},
                                   {"range", u32, 32, Content::kRangeMillimetres}},
                                  48,
                                  Missing::kZero,
                                  true};
  static const CloudLayout hesai{{x,
                                  y,
                                  z,
                                  {"intensity", f32, 16, Content::kIntensity},
                                  {"timestamp", f64, 24, Content::kTime},
                                  {"ring", u16, 32, Content::kRing}},
                                 48,
                                 Missing::kRejected,
                                 false};
  static const CloudLayout robosense{{x,
                                      y,
                                      z,
                                      {"intensity", f32, 12, Content::kIntensity},
                                      {"ring", u16, 16, Content::kRing},
                                      {"timestamp", f64, 18, Content::kTime}},
                                     26,
                                     Missing::kNan,
                                     false};
  static const CloudLayout no_time{
      {x, y, z, {"intensity", f32, 12, Content::kIntensity}, {"ring", u16, 16, Content::kRing}},
      18,
      Missing::kRejected,
      false};
  switch (layout) {
    case PointLayout::kVelodyne:
      return velodyne;
    case PointLayout::kOuster:
      return ouster;
    case PointLayout::kHesai:
      return hesai;
    case PointLayout::kRobosense:
      return robosense;
    case PointLayout::kNoTime:
      return no_time;
    case PointLayout::kLivox:
      break;
  }
  throw InternalError("point layout without a point cloud");
}

template <typename T>
void Put(std::uint8_t* at, T value) {
  std::memcpy(at, &value, sizeof value);
}

void PutTime(const Field& field, const sim::SimulatedScan& scan, double time, std::uint8_t* at) {
  switch (field.type) {
    case PointField::FLOAT64:  // absolute
      Put(at, 1e-9 * static_cast<double>(TimeFrom(scan.start, time)));
      return;
    case PointField::UINT32:  // ns after the stamp
      Put(at, static_cast<std::uint32_t>(TimeFrom(scan.start, time) - scan.stamp));
      return;
    default:  // s after the stamp
      Put(at, static_cast<float>(SecondsSince(scan.stamp, scan.start) + time));
  }
}

void PutPoint(const CloudLayout& layout, const sim::SimulatedScan& scan, const sim::SimulatedPoint& point,
              std::uint8_t* at) {
  Eigen::Vector3f position = point.position;
  if (!point.returned && layout.missing == Missing::kNan) {
    position.setConstant(std::numeric_limits<float>::quiet_NaN());
  }
  for (const Field& field : layout.fields) {
    std::uint8_t* to = at + field.offset;
    switch (field.content) {
      case Content::kX:
        Put(to, position.x());
        break;
      case Content::kY:
        Put(to, position.y());
        break;
      case Content::kZ:
        Put(to, position.z());
        break;
      case Content::kIntensity:
        Put(to, point.intensity);
        break;
      case Content::kRing:
        Put(to, point.ring);
        break;
      case Content::kRangeMillimetres:
        Put(to, static_cast<std::uint32_t>(std::lround(1000.0f * point.position.norm())));
        break;
      case Content::kTime:
        PutTime(field, scan, point.time, to);
        break;
      case Content::kZero:
        break;
    }
  }
}

std_msgs::Header MakeHeader(const sim::SimulatedLidar& lidar, const sim::SimulatedScan& scan) {
  std_msgs::Header header;
  header.stamp.fromNSec(static_cast<std::uint64_t>(scan.stamp));
  header.frame_id = lidar.frame_id;
  return header;
}

}  // namespace

sensor_msgs::PointCloud2 MakePointCloud(const sim::SimulatedLidar& lidar, const sim::SimulatedScan& scan) {
  const CloudLayout& layout = LayoutOf(lidar.layout);
  sensor_msgs::PointCloud2 cloud;
  cloud.header = MakeHeader(lidar, scan);
  cloud.point_step = layout.point_step;
  cloud.is_dense = layout.missing != Missing::kNan;
  for (const Field& field : layout.fields) {
    PointField description;
    description.name = field.name;
    description.datatype = field.type;
    description.offset = field.offset;
    description.count = 1;
    cloud.fields.push_back(description);
  }
  cloud.data.resize(scan.points.size() * layout.point_step);
  // Beams come column by column, all rings of a column in order.
  const std::size_t rings = layout.ring_major ? static_cast<std::size_t>(lidar.model.rings) : 1;
  const std::size_t columns = scan.points.size() / rings;
  std::size_t written = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const sim::SimulatedPoint& point = scan.points[(i % columns) * rings + i / columns];
    if (!point.returned && layout.missing == Missing::kRejected) continue;
    PutPoint(layout, scan, point, &cloud.data[written++ * layout.point_step]);
  }
  cloud.data.resize(written * layout.point_step);
  cloud.height = static_cast<std::uint32_t>(rings);
  cloud.width = static_cast<std::uint32_t>(written / rings);
  cloud.row_step = cloud.width * cloud.point_step;
  return cloud;
}

LivoxMessage MakeLivoxMessage(const sim::SimulatedLidar& lidar, const sim::SimulatedScan& scan) {
  LivoxMessage message{};
  message.header = MakeHeader(lidar, scan);
  message.timebase = static_cast<std::uint64_t>(scan.start);
  message.point_num = static_cast<std::uint32_t>(scan.points.size());
  message.points.reserve(scan.points.size());
  constexpr std::uint8_t kConfidentReturn = 0x10;  // from: standard, Livox SDK
  for (const sim::SimulatedPoint& p : scan.points) {
    LivoxPoint point{};
    point.offset_time = static_cast<std::uint32_t>(std::llround(1e9 * p.time));
    point.x = p.position.x(), point.y = p.position.y(), point.z = p.position.z();
    point.reflectivity = static_cast<std::uint8_t>(std::lround(p.intensity));
    point.tag = p.returned ? kConfidentReturn : 0;
    point.line = static_cast<std::uint8_t>(p.ring);
    message.points.push_back(point);
  }
  return message;
}

}  // namespace mlic

const char* ros::message_traits::Definition<mlic::LivoxMessage>::value() {
  return "std_msgs/Header header\n"
         "uint64 timebase\n"
         "uint32 point_num\n"
         "uint8 lidar_id\n"
         "uint8[3] rsvd\n"
         "livox_ros_driver/CustomPoint[] points\n"
         "================================================================================\n"
         "MSG: std_msgs/Header\n"
         "uint32 seq\n"
         "time stamp\n"
         "string frame_id\n"
         "================================================================================\n"
         "MSG: livox_ros_driver/CustomPoint\n"
         "uint32 offset_time\n"
         "float32 x\n"
         "float32 y\n"
         "float32 z\n"
         "uint8 reflectivity\n"
         "uint8 tag\n"
         "uint8 line\n";
}
