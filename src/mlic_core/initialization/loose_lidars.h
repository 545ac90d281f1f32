#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/imu/angular_rate_alignment.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// By how much a LiDAR is turned against the IMU between the two halves of a drive, along what the motion of
// both shows.
struct MountTurn {
  double angle = 0.0;   // rad
  double sigmas = 0.0;  // of the odometry's noise
};

// From the LiDAR's odometry and the gyroscope alone, each half aligned by itself; cut where half of the
// turning lies behind. Nothing where a half's alignment is not usable.
std::optional<MountTurn> MeasureMountTurn(const std::vector<ImuSample>& imu,
                                          const std::vector<TimedPose>& odometry,
                                          const AngularRateAlignment& whole);

// Of each LiDAR's turn in one drive (none: not measured) whether it came loose: turned by more than 0.3 deg
// while another did not by half as much. In one map with the others, it would bend the trajectory, and all
// would be refused. Smaller turns are left to the halves of the calibration itself (split_halves.h); where
// all turn it is the IMU.
std::vector<bool> FindLoose(const std::vector<std::optional<MountTurn>>& turns);

// One line for people why such a LiDAR takes no part.
std::string WhyLoose(const LidarConfig& config);

}  // namespace mlic
