#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What all sensors of a kind see at one moment, the middle of the drive (trajectory: T_map_imu), put together
// by the calibration alone: no map helps.

// One scan of each LiDAR from above within 15 m of the IMU, a colour for each, every point at its own time;
// what the rig drives to is above. drive.lidars[i] is the LiDAR of that name in `names`. Empty where no LiDAR
// has a scan there.
cv::Mat DrawScansFromAbove(const Drive& drive, const std::vector<std::string>& names,
                           const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory);

// One photo of each camera on a sphere of 20 m about the IMU, all around, from 60 deg below the horizon to 45
// above; ahead is in the middle. What is nearer or farther than the sphere is doubled where cameras overlap,
// by their distance to each other. drive.cameras[i] is the camera of that name in `names`.
cv::Mat DrawPanorama(const Drive& drive, const std::vector<std::string>& names,
                     const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory);

}  // namespace mlic
