#pragma once

#include <pcl/point_cloud.h>
#include <pcl/register_point_struct.h>
#include <pcl_conversions/pcl_conversions.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <cstring>

namespace mlic {

// 0x00RRGGBB as PCL and RViz read a colour: the bits of a float.
inline float PackColour(std::uint32_t colour) {
  float packed = 0.0f;
  std::memcpy(&packed, &colour, sizeof(packed));
  return packed;
}

// The points, of a type that is registered with PCL, as a message in frame map.
template <typename Point>
sensor_msgs::PointCloud2 MakeCloudMessage(const pcl::PointCloud<Point>& cloud, const ros::Time& stamp) {
  sensor_msgs::PointCloud2 message;
  pcl::toROSMsg(cloud, message);
  message.header.frame_id = "map";
  message.header.stamp = stamp;
  return message;
}

}  // namespace mlic
