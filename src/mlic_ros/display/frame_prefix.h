#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>

namespace mlic {

// Puts all frames of a message below the prefix: in a tree of their own, so that no frame of a robot that
// runs beside the calibration gets a second parent.
void AddFramePrefix(const std::string& prefix, std_msgs::Header* header);
void AddFramePrefix(const std::string& prefix, geometry_msgs::TransformStamped* frame);
void AddFramePrefix(const std::string& prefix, nav_msgs::Path* path);
void AddFramePrefix(const std::string& prefix, sensor_msgs::Image* image);
void AddFramePrefix(const std::string& prefix, sensor_msgs::PointCloud2* cloud);
void AddFramePrefix(const std::string& prefix, visualization_msgs::MarkerArray* markers);

// "robot", "/robot/" and "robot/" are "robot/"; empty stays empty: no prefix.
std::string ToFramePrefix(const std::string& text);

}  // namespace mlic
