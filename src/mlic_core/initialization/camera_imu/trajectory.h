#pragma once

#include "mlic_core/imu/excitation.h"
#include "mlic_core/initialization/camera_imu/positions.h"
#include "mlic_core/initialization/knot_spacing.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// The trajectory and biases of one drive from positions in the gyro frame: turned upright everywhere by the
// gravity found there, first position and yaw zero, then the spline is fitted to these poses and the IMU.
DriveState UprightTrajectory(const Drive& drive, const GyroIntegration& gyro,
                             const Eigen::Vector3d& gyroscope_bias, const DrivePositions& positions,
                             const KnotSpacing& spacing, const ImuSigma& imu_sigma);

}  // namespace mlic
