#include "mlic_ros/display/display_messages.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mlic_ros/display/display_clouds.h"

namespace mlic {

// A point of the map as PCL knows it; the names become the message's fields.
// In no anonymous namespace: there clang warns of the operators that the macro defines and nobody calls.
struct DisplayPoint {
  float x, y, z, intensity, rgb;
  std::uint16_t lidar;
  std::int32_t plane;
};

}  // namespace mlic

POINT_CLOUD_REGISTER_POINT_STRUCT(mlic::DisplayPoint,
                                  (float, x, x)(float, y, y)(float, z, z)(float, intensity, intensity)(
                                      float, rgb, rgb)(std::uint16_t, lidar, lidar)(std::int32_t, plane,
                                                                                    plane))

namespace mlic {
namespace {

constexpr std::size_t kMostPoints = 400000;  // from: guard, what RViz draws fluently
constexpr const char* kMapFrame = "map";
constexpr float kPlaneOpacity = 0.5f;  // from: structural

SensorStatus MakeStatus(const std::string& name, const std::string& frame,
                        const SensorCalibration& calibration, const PoseSigma* sigma) {
  SensorStatus status;
  status.name = name;
  status.frame_id = FrameName(frame, name);
  status.state = SensorStatus::ESTIMATED;
  status.transform = ToMessage(calibration.T_imu_sensor);
  status.time_offset = calibration.time_offset;
  status.has_sigma = sigma != nullptr;
  for (int axis = 0; sigma != nullptr && axis < 3; ++axis) {
    status.sigma_translation[axis] = sigma->translation[axis];
    status.sigma_rotation_deg[axis] = sigma->rotation[axis] * 180.0 / M_PI;
    status.sigma_time_offset = sigma->time_offset;
  }
  return status;
}

}  // namespace

geometry_msgs::Point ToPoint(const Eigen::Vector3d& p) {
  geometry_msgs::Point point;
  point.x = p.x();
  point.y = p.y();
  point.z = p.z();
  return point;
}

std_msgs::ColorRGBA ToColour(std::uint32_t rgb, float opacity) {
  std_msgs::ColorRGBA colour;
  colour.r = static_cast<float>(rgb >> 16 & 0xffu) / 255.0f;
  colour.g = static_cast<float>(rgb >> 8 & 0xffu) / 255.0f;
  colour.b = static_cast<float>(rgb & 0xffu) / 255.0f;
  colour.a = opacity;
  return colour;
}

geometry_msgs::Transform ToMessage(const RigidTransform& transform) {
  geometry_msgs::Transform message;
  message.translation.x = transform.translation.x();
  message.translation.y = transform.translation.y();
  message.translation.z = transform.translation.z();
  message.rotation.x = transform.rotation.x();
  message.rotation.y = transform.rotation.y();
  message.rotation.z = transform.rotation.z();
  message.rotation.w = transform.rotation.w();
  return message;
}

geometry_msgs::TransformStamped MakeFrame(const std::string& parent, const std::string& child,
                                          const geometry_msgs::Transform& transform, const ros::Time& stamp) {
  geometry_msgs::TransformStamped frame;
  frame.header.stamp = stamp;
  frame.header.frame_id = parent;
  frame.child_frame_id = child;
  frame.transform = transform;
  return frame;
}

std::string FrameName(const std::string& frame, const std::string& fallback) {
  const std::string name = !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
  return name.empty() ? fallback : name;
}

visualization_msgs::MarkerArray MakePlaneMarkers(const std::vector<PlanePatch>& planes,
                                                 const std::vector<std::uint32_t>& colours,
                                                 const ros::Time& stamp) {
  visualization_msgs::Marker marker;
  marker.header.frame_id = kMapFrame;
  marker.header.stamp = stamp;
  marker.ns = "planes";
  marker.type = visualization_msgs::Marker::TRIANGLE_LIST;
  marker.action = visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.color.a = 1.0f;
  // Points spread evenly over a rectangle reach sqrt(3) standard deviations from its centre.
  const double reach = std::sqrt(3.0);
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const PlanePatch& plane = planes[k];
    const std_msgs::ColorRGBA colour = ToColour(colours[k], kPlaneOpacity);
    const Eigen::Vector3d u = reach * plane.axis_u, v = reach * plane.axis_v;
    const std::array<Eigen::Vector3d, 4> corners{plane.center - u - v, plane.center + u - v,
                                                 plane.center + u + v, plane.center - u + v};
    for (const int corner : {0, 1, 2, 0, 2, 3}) {
      marker.points.push_back(ToPoint(corners[corner]));
      marker.colors.push_back(colour);
    }
  }
  visualization_msgs::MarkerArray array;
  array.markers.push_back(marker);
  return array;
}

sensor_msgs::PointCloud2 MakeMapCloud(const std::vector<MapPoint>& points,
                                      const std::vector<std::uint32_t>& colours, const ros::Time& stamp) {
  const std::size_t stride = std::max<std::size_t>(1, (points.size() + kMostPoints - 1) / kMostPoints);
  pcl::PointCloud<DisplayPoint> cloud;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const MapPoint& from = points[i];
    DisplayPoint point{};
    point.x = from.position.x(), point.y = from.position.y(), point.z = from.position.z();
    point.intensity = from.intensity;
    point.rgb = PackColour(colours[i]);
    point.lidar = static_cast<std::uint16_t>(std::max(0, from.lidar));
    point.plane = from.plane;
    cloud.push_back(point);
  }
  return MakeCloudMessage(cloud, stamp);
}

nav_msgs::Path MakePath(const std::vector<StampedPose>& trajectory, const ros::Time& stamp) {
  nav_msgs::Path path;
  path.header.frame_id = kMapFrame;
  path.header.stamp = stamp;
  for (const StampedPose& pose : trajectory) {
    geometry_msgs::PoseStamped message;
    message.header.frame_id = kMapFrame;
    message.header.stamp.fromNSec(static_cast<std::uint64_t>(std::max<TimeNs>(0, pose.time)));
    const geometry_msgs::Transform transform = ToMessage(pose.pose);
    message.pose.position = ToPoint(pose.pose.translation);
    message.pose.orientation = transform.rotation;
    path.poses.push_back(message);
  }
  return path;
}

std::vector<SensorStatus> MakeSensorStatus(const CalibrationSnapshot& snapshot) {
  std::vector<SensorStatus> sensors;
  for (std::size_t i = 0; i < snapshot.sensors.size(); ++i) {
    const PoseSigma* sigma = i < snapshot.sigmas.size() ? &snapshot.sigmas[i] : nullptr;
    const std::string name = i < snapshot.sensor_names.size() ? snapshot.sensor_names[i] : std::to_string(i);
    const std::string frame = i < snapshot.sensor_frames.size() ? snapshot.sensor_frames[i] : "";
    sensors.push_back(MakeStatus(name, frame, snapshot.sensors[i], sigma));
    sensors.back().is_camera = i + snapshot.intrinsics.size() >= snapshot.sensors.size();
  }
  return sensors;
}

std::vector<SensorStatus> MakeSensorStatus(const CalibrationResult& result) {
  std::vector<SensorStatus> sensors;
  for (const SensorResult& sensor : result.sensors) {
    sensors.push_back(MakeStatus(sensor.name, sensor.frame_id, sensor.calibration, &sensor.sigma));
    sensors.back().is_camera = sensor.type == SensorResult::Type::kCamera;
  }
  return sensors;
}

}  // namespace mlic
