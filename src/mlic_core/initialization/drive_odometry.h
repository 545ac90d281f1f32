#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/imu/angular_rate_alignment.h"
#include "mlic_core/imu/gravity_lever_arm.h"
#include "mlic_core/initialization/clock_drift.h"
#include "mlic_core/lidar/odometry.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// Odometry of every LiDAR in one drive, and each LiDAR's alignment with the gyroscope.
struct DriveOdometry {
  std::vector<std::vector<TimedPose>> lidars;  // RunOdometry, the clock's drift taken out of the times
  std::vector<AngularRateAlignment> alignments;
  std::vector<ClockDrift> clocks;  // 0 unless it is so large that it must be known from the start
};

// docs/method.md, sections 5 and 7.1: all LiDARs in parallel; aligned with the gyroscope, where they do not
// agree also from a map that forgets, and predicted by the gyroscope with the guess; run again with gyro
// de-skew where that is known; and where accelerations tell of slips, also by the accelerometer, as long as
// that helps.
DriveOdometry RunDriveOdometry(const Rig& rig, const Drive& drive, const CancellationToken& cancellation,
                               const std::function<void(double)>& on_progress);

std::optional<LeverArmGuess> LeverArmGuessOf(const LidarConfig& lidar);

// A LiDAR's odometry against gyroscope and accelerometer, rad m; smaller is better. Where a narrow view holds
// floor and one wall for some seconds, odometry slips along them: rotation does not tell, accelerations do.
double Disagreement(const AngularRateAlignment& alignment, const GravityLeverArm& arm);

}  // namespace mlic
