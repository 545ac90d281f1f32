#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>

namespace mlic {

// Of a LiDAR by its index in CalibrationResult::sensors, on a dark ground; BGR.
inline cv::Scalar ColourOfLidar(std::size_t sensor) {
  static const cv::Scalar kColours[] = {{255, 160, 80},  {60, 150, 255}, {110, 220, 110}, {200, 110, 255},
                                        {255, 110, 190}, {220, 220, 60}, {90, 210, 230},  {180, 180, 180}};
  return kColours[sensor % 8];
}

}  // namespace mlic
