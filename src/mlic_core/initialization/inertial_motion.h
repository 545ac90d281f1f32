#pragma once

#include "mlic_core/imu/angular_rate_alignment.h"
#include "mlic_core/imu/gravity_lever_arm.h"
#include "mlic_core/initialization/clock_drift.h"
#include "mlic_core/lidar/deskew.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// How the IMU says that a LiDAR turns, once they are aligned. `clock` is taken out of the LiDAR's times.
InertialMotion RotationByImu(const std::vector<ImuSample>& imu, const AngularRateAlignment& alignment,
                             const ClockDrift& clock);

// Also how it gains velocity, by `arm`, which must be valid.
InertialMotion MotionByImu(const std::vector<ImuSample>& imu, const AngularRateAlignment& alignment,
                           const GravityLeverArm& arm, const ClockDrift& clock);

}  // namespace mlic
