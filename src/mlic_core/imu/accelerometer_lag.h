#pragma once

#include "mlic_core/imu/angular_rate_alignment.h"
#include "mlic_core/imu/gravity_lever_arm.h"

namespace mlic {

// By how much the accelerometer's readings are later than the gyroscope's under the same stamps. Zero for an
// IMU; navigation systems filter their readings, and then one time offset cannot serve all of them (a real
// INS: rates 63 ms late, lateral accelerations about as much, longitudinal ones 9 ms). One lag for all axes:
// that of those which the motion excites most.
struct AccelerometerLag {
  bool valid = false;  // false: the motion does not show it
  double lag = 0.0;    // s; positive: the accelerometer is the later one
  double sigma = 0.0;  // s
};

// The gyroscope's clock is that of `alignment`, which knows nothing of accelerations. The specific force is
// shifted against it, up to 150 ms, until gravity and lever arm (SolveGravityLeverArm) leave the least
// residual.
AccelerometerLag MeasureAccelerometerLag(const std::vector<ImuSample>& imu,
                                         const std::vector<TimedPose>& poses,
                                         const AngularRateAlignment& alignment,
                                         const std::optional<LeverArmGuess>& guess);

}  // namespace mlic
