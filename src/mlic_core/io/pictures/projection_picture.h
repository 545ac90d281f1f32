#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// Six panels of the photo's size, at most 960 px wide each. Left and right: the photo with the matches (a
// ring where a place of the map was found, a red arrow to where the calibration projects it, magnified) and
// the rendering (blue where nothing is seen); LiDAR points on the photo by depth (red near, blue far,
// logarithmic), before and after; LiDAR points by intensity, before and after. Two where the camera was not
// found: the points at the guess. photo: CV_8UC1 or CV_8UC3.
cv::Mat DrawProjection(const cv::Mat& photo, const CameraProjection& projection);

// m, the range of depths that the colours span, from red to blue.
struct DepthRange {
  float near = 0.0f, far = 0.0f;
};

// The photo with the LiDAR points by depth, both with one scale of colours: at the guess (where there is
// none, before the last stage), and after. Without titles, as one is laid over the other.
struct OverlayPair {
  cv::Mat before, after;
  DepthRange range;
};
OverlayPair DrawOverlays(const cv::Mat& photo, const CameraProjection& projection);

// The photo, at most 960 px wide, with the LiDAR points by depth as there. when: for the legend.
cv::Mat DrawByDepth(const cv::Mat& photo, const std::vector<ProjectedPoint>& points, const std::string& when);

// Loads the photos and writes DIRECTORY/NAME_projection.png.
void WriteProjectionPictures(const std::filesystem::path& directory,
                             const std::vector<CameraProjection>& projections);

}  // namespace mlic
