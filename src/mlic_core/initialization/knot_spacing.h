#pragma once

#include <limits>
#include <vector>

#include "mlic_core/sensors/measurements.h"

namespace mlic {

struct KnotSpacing {
  double rotation = 0.1;  // s
  double position = 0.1;  // s
};

// The coarsest spacings (docs/method.md, section 2) with which the splines follow the measured motion to
// within the IMU's noise: quadratic splines are fitted to the gyroscope (the derivative of a cubic rotation
// spline), linear ones to the accelerometer (the second derivative of a cubic position spline), and the
// spacing grows while what the fit loses of the motion below the finest spacing's half rate stays within 1
// percent of the noise, whatever vibrates above. Samples show nothing finer than two of their periods. Where
// motion is left over at that (navigation systems at 10 Hz), LiDAR scans, each of which shows a whole pose,
// take the spacing down to lidar_period (s; their period).
KnotSpacing ChooseKnotSpacing(const std::vector<ImuSample>& imu,
                              double lidar_period = std::numeric_limits<double>::infinity());

}  // namespace mlic
