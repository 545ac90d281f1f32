#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "mlic_core/calibration/joint_problem.h"

namespace mlic {

// A stretch of a drive over which the IMU contradicts the trajectory that LiDARs and cameras give: residuals
// whose mean over a second is far above what white noise leaves of it.
struct ImuDisagreement {
  std::size_t drive = 0;
  double begin = 0.0, end = 0.0;  // s since the trajectory's start, whole seconds
  bool of_gyroscope = false;      // or of the accelerometer
  double mean = 0.0;              // of the worst second: rad/s or m/s^2
  double ratio = 0.0;             // of it to the noise of such a mean
};

// The worst second of all drives and the seconds around it that are as bad as least_ratio; nothing where none
// is. A trajectory that odometry lost for some seconds and that the map did not catch shows so: its points
// find planes elsewhere or none, and only the IMU tells.
std::optional<ImuDisagreement> FindImuDisagreement(const Dataset& dataset, const CalibrationState& state,
                                                   const std::vector<ImuSigma>& sigmas, double least_ratio);

}  // namespace mlic
