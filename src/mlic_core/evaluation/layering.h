#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// The LiDARs' map of one drive as one state of the calibration makes it; MapPoint::lidar is an index in
// `sensors`.
struct MapState {
  std::string title;
  std::vector<MapPoint> map;
  std::vector<std::string> sensors;  // their names
};

// The same cross-section through the map in each state, one below the other: how the layers that LiDARs make
// of one surface come together. Left through a wall, right through the ground, at the places that most LiDARs
// see well in the last state; 2 m of the surface, 20 cm to either side of it enlarged three times, what lies
// within 25 cm of the section; a colour for each LiDAR. Empty without points on such a surface.
cv::Mat DrawLayering(const std::vector<MapState>& states);

}  // namespace mlic
