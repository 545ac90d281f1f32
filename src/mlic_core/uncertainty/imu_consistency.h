#pragma once

#include <cstddef>
#include <vector>

#include "mlic_core/imu/imu_sigma_course.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/measurements.h"

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

// The stretches of all drives whose seconds are beyond least_ratio and stand out from the drive's others (a
// bias that wanders raises all of them). A trajectory that odometry lost for some seconds and that the map
// did not catch shows so: its points find planes elsewhere or none, and only the IMU shows it.
// docs/method.md, section 12.
std::vector<ImuDisagreement> FindImuDisagreements(const Dataset& dataset, const CalibrationState& state,
                                                  const std::vector<ImuSigmaCourse>& sigmas,
                                                  double least_ratio);

}  // namespace mlic
