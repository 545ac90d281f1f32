#pragma once

#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/initialization/drive_odometry.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

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

// Whether a drive turns enough, by the gyroscope, for a sensor that can be followed to be found by its
// rotation.
bool TurnsEnough(const Dataset& dataset);

// docs/method.md, sections 7.2 to 7.4: base LiDAR by the smallest disagreement with the gyroscope, gravity,
// biases and lever arm, the IMU spline, hand-eye for the other LiDARs.
Initialization Initialize(const Rig& rig, const Dataset& dataset, const std::vector<DriveOdometry>& odometry,
                          const CancellationToken& cancellation);

}  // namespace mlic
