#pragma once

#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/result/observer.h"

namespace mlic {

// Messages that show what cameras add to a calibration.

constexpr float kLargeReprojectionError = 3.0f;  // px, beyond which the colour is the same; from: structural
std::uint32_t ColourOfError(float error);        // px; 0xRRGGBB from white (none) to red

// Fields x y z, rgb (by its error), error f32 (px), observations u16, in frame map.
sensor_msgs::PointCloud2 MakeLandmarkCloud(const std::vector<LandmarkMark>& landmarks,
                                           const ros::Time& stamp);

// The outline of what each camera of the snapshot sees, at most half a metre before it and nearer on a small
// rig, in the camera's own frame.
visualization_msgs::MarkerArray MakeFrustumMarkers(const CalibrationSnapshot& snapshot);

// A picture (CV_8UC3, BGR) as a message.
sensor_msgs::Image MakeImage(const cv::Mat& picture, const std::string& frame, const ros::Time& stamp);

// The pictures in a grid of no more columns than rows, each shrunk to a tile of this width with its name
// large enough for a narrow window; black where there is none.
cv::Mat TilePictures(const std::vector<cv::Mat>& pictures, const std::vector<std::string>& names,
                     int tile_width);

// A name as part of a topic: what ROS does not allow becomes an underscore.
std::string TopicPart(const std::string& name);

}  // namespace mlic
