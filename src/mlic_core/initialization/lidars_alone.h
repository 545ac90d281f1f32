#pragma once

#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// Sensors of one drive that nothing ties to the IMU, as a problem of their own in which one LiDAR, the root,
// is where the IMU would be: extrinsics are T_root_sensor, times the root's. docs/method.md, section 7.7.
struct LidarsAlone {
  std::size_t root = 0;
  bool parked = false;     // nothing moves: time offsets mean nothing to the poses
  std::vector<bool> tied;  // of each LiDAR: its map was found in that of the others
  // Guesses and time offsets against the root, which is fixed. A camera has no guess where it or the root has
  // none.
  Rig rig;
  // As much of the first drive as is used, with the root's own motion in place of the IMU's samples: so loose
  // (Initialization::imu_sigma) that they only keep the trajectory smooth where no point tells.
  Dataset dataset;
  Initialization start;  // without cameras; its problems: of LiDARs that were not tied
  // s, of each LiDAR's and then each camera's time offset to the root's: how well it is known before the maps
  // are asked. 0: not at all needed, the gyroscope has shown it.
  std::vector<double> time_offset_sigmas;
};

// From the odometry of each LiDAR alone and the maps that it makes. Where no LiDAR's map is found in
// another's and no camera has a guess, the start has no drive.
LidarsAlone InitializeLidarsAlone(const Rig& rig, const Dataset& dataset, const DriveOdometry& odometry,
                                  const CancellationToken& cancellation);

}  // namespace mlic
