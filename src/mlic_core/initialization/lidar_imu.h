#pragma once

#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/imu/angular_rate_alignment.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/lidar/odometry.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What a clock gains on the IMU's beyond a constant: drift * (t - middle). drift: s/s; middle: s since the
// drive's epoch.
struct ClockDrift {
  double drift = 0.0;
  double middle = 0.0;

  double Without(double time) const { return time + drift * (time - middle); }
};

// Odometry of every LiDAR in one drive, and each LiDAR's alignment with the gyroscope.
struct DriveOdometry {
  std::vector<std::vector<TimedPose>> lidars;  // RunOdometry, the clock's drift taken out of the times
  std::vector<AngularRateAlignment> alignments;
  std::vector<ClockDrift> clocks;  // 0 unless it is so large that it must be known from the start
};

// What the initialisation found; problems are reasons for refusal, in plain words.
struct Initialization {
  CalibrationState state;
  std::vector<ImuSigma> imu_sigma;
  std::size_t base_lidar = 0;
  // Of each LiDAR: it starts from its guess alone, as its odometry told nothing.
  std::vector<bool> unaligned;
  std::vector<bool> loose;  // of each LiDAR: it came loose (loose_lidars.h), and takes no part
  std::vector<std::string> problems;
  std::vector<std::string> notes;
};

// docs/method.md, sections 5 and 7.1: all LiDARs in parallel; aligned with the gyroscope; run again with gyro
// de-skew where that is known.
DriveOdometry RunDriveOdometry(const Rig& rig, const Drive& drive, const CancellationToken& cancellation,
                               const std::function<void(double)>& on_progress);

// docs/method.md, sections 7.2 to 7.4: base LiDAR by the smallest disagreement with the gyroscope, gravity,
// biases and lever arm, the IMU spline, hand-eye for the other LiDARs.
Initialization Initialize(const Rig& rig, const Dataset& dataset, const std::vector<DriveOdometry>& odometry,
                          const CancellationToken& cancellation);

}  // namespace mlic
