#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/result/coloured_point.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

struct MapColourOptions {
  std::size_t photos = 40;  // of each camera, spread over the drive; from: guard, time
  double farthest = 30.0;   // m, of a point from the camera that gives its colour; from: structural
  // m, how large a point is that hides others behind it; from: structural
  double point_size = 0.12;
};

// The points of a map that some photo sees, in the colours that the photos have there: the mean, near cameras
// counting more. Edges of colour lie on edges of shape as well as cameras and LiDARs are calibrated to each
// other. A point that others hide from a camera gets no colour from it; what moves leaves its colours behind.
// drive.cameras[i] is the camera of that name in `names`.
std::vector<ColouredPoint> ColourMap(const std::vector<MapPoint>& map, const Drive& drive,
                                     const std::vector<std::string>& names,
                                     const CalibrationResult& calibration,
                                     const std::vector<StampedPose>& trajectory,
                                     const MapColourOptions& options, const CancellationToken& cancellation);

// The points from obliquely above, 1200 x 800 px. What is more than 1.5 m above the trajectory is left out,
// so that one looks into rooms. Empty without points.
cv::Mat DrawColouredMap(const std::vector<ColouredPoint>& points, const std::vector<StampedPose>& trajectory);

}  // namespace mlic
