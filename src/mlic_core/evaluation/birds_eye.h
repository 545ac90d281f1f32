#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

struct BirdsEyeOptions {
  double half_width = 10.0;  // m, of the picture, about the IMU; from: structural
  double pixel = 0.02;       // m; from: structural
};

// The ground around the rig from above, as all cameras see it at one moment.
struct BirdsEye {
  cv::Mat picture;                   // CV_8UC3; what the rig drives to is above
  std::vector<std::string> cameras;  // that show some of it
  double seconds = 0.0;              // of the moment, since the drive's epoch
};

// Each place of the ground has the mean of what the photos of that moment show there, those of near cameras
// counting more: where cameras overlap, lines on the ground meet as well as the calibration is. Of each
// camera the photo nearest to the middle of the trajectory is taken, at its own time. The ground is the plane
// of calibration.ground, which must be there, so what stands on it is drawn out away from the cameras.
// drive.cameras[i] is the camera of that name in `names`.
BirdsEye DrawBirdsEye(const Drive& drive, const std::vector<std::string>& names,
                      const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory,
                      const BirdsEyeOptions& options);

// Whether calibration.ground is where the ground is at each moment: of a vehicle, whose IMU keeps its height
// and inclination, and not of what is carried.
bool StandsOnTheGround(const CalibrationResult& calibration);

}  // namespace mlic
