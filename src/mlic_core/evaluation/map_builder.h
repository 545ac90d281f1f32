#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// The map of a drive under a given calibration: all points of lidars[i], named names[i], at the poses of the
// trajectory (T_map_imu, IMU clock; interpolated linearly and by slerp, so a dense one), every `stride`-th
// one. LiDARs that the calibration lacks and points outside the trajectory are left out. MapPoint::lidar is
// the index in calibration.sensors.
std::vector<MapPoint> BuildMap(const Drive& drive, const std::vector<std::string>& names,
                               const std::vector<StampedPose>& trajectory,
                               const CalibrationResult& calibration, std::size_t stride);

}  // namespace mlic
