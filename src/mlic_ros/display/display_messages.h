#pragma once

#include <geometry_msgs/Point.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

#include "mlic/SensorStatus.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"

namespace mlic {

// Messages for RViz. Everything with a header is in frame map.

geometry_msgs::Point ToPoint(const Eigen::Vector3d& p);

std_msgs::ColorRGBA ToColour(std::uint32_t rgb, float opacity);  // 0xRRGGBB

geometry_msgs::Transform ToMessage(const RigidTransform& transform);

geometry_msgs::TransformStamped MakeFrame(const std::string& parent, const std::string& child,
                                          const geometry_msgs::Transform& transform, const ros::Time& stamp);

// tf2's form of a frame name (no leading slash); `fallback` where it is empty.
std::string FrameName(const std::string& frame, const std::string& fallback);

// Each plane as a rectangle of its extent. colours: 0xRRGGBB of each.
visualization_msgs::MarkerArray MakePlaneMarkers(const std::vector<PlanePatch>& planes,
                                                 const std::vector<std::uint32_t>& colours,
                                                 const ros::Time& stamp);

// Fields x y z, intensity f32, rgb (the point's one of `colours`, 0xRRGGBB), lidar u16, plane i32 (-1: none).
// At most 400,000 points, evenly chosen.
sensor_msgs::PointCloud2 MakeMapCloud(const std::vector<MapPoint>& points,
                                      const std::vector<std::uint32_t>& colours, const ros::Time& stamp);

nav_msgs::Path MakePath(const std::vector<StampedPose>& trajectory, const ros::Time& stamp);

std::vector<SensorStatus> MakeSensorStatus(const CalibrationSnapshot& snapshot);
std::vector<SensorStatus> MakeSensorStatus(const CalibrationResult& result);

}  // namespace mlic
