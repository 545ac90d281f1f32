#include "mlic_ros/display/frame_prefix.h"

namespace mlic {

void AddFramePrefix(const std::string& prefix, std_msgs::Header* header) {
  header->frame_id.insert(0, prefix);
}

void AddFramePrefix(const std::string& prefix, geometry_msgs::TransformStamped* frame) {
  AddFramePrefix(prefix, &frame->header);
  frame->child_frame_id.insert(0, prefix);
}

void AddFramePrefix(const std::string& prefix, nav_msgs::Path* path) {
  AddFramePrefix(prefix, &path->header);
  for (geometry_msgs::PoseStamped& pose : path->poses) AddFramePrefix(prefix, &pose.header);
}

void AddFramePrefix(const std::string& prefix, sensor_msgs::Image* image) {
  AddFramePrefix(prefix, &image->header);
}

void AddFramePrefix(const std::string& prefix, sensor_msgs::PointCloud2* cloud) {
  AddFramePrefix(prefix, &cloud->header);
}

void AddFramePrefix(const std::string& prefix, visualization_msgs::MarkerArray* markers) {
  for (visualization_msgs::Marker& marker : markers->markers) AddFramePrefix(prefix, &marker.header);
}

std::string ToFramePrefix(const std::string& text) {
  const std::size_t first = text.find_first_not_of('/');
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of('/') + 1 - first) + "/";
}

}  // namespace mlic
