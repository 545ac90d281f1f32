#pragma once

#include <vector>

#include "mlic_core/sensors/measurements.h"

namespace mlic {

struct KnotSpacing {
  double rotation = 0.1;  // s
  double position = 0.1;  // s
};

// The coarsest spacings with which the splines follow the measured motion to within the IMU's noise:
// quadratic splines are fitted to the gyroscope (the derivative of a cubic rotation spline), linear ones to
// the accelerometer (the second derivative of a cubic position spline), and the spacing grows while the
// residual variance, freed of the fit's degrees of freedom, stays within 1 percent (rotation) or 5 percent
// (position) of the finest one's. Never finer than two IMU periods.
KnotSpacing ChooseKnotSpacing(const std::vector<ImuSample>& imu);

}  // namespace mlic
