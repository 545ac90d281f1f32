#pragma once

#include <vector>

#include "mlic_core/initialization/camera_on_trajectory.h"
#include "mlic_core/initialization/lidar_imu.h"

namespace mlic {

// docs/method.md, section 7.6, for a rig without LiDARs: trajectory, cameras and biases from the cameras'
// tracks and the IMU alone, the scale from the accelerometer. tracks: of each drive. The state holds the
// cameras too, after rounds of triangulation and solving in which everything moves; cameras that were not
// found stay at their guess. Where the drives do not show enough, the state has no drives and the problems
// say why. cameras: what InitializeCameras tells, where the state has drives; else only which were found and
// the problems of the others.
Initialization InitializeFromCameras(const Rig& rig, const Dataset& dataset,
                                     const std::vector<CameraStart>& start,
                                     const std::vector<TrackSet>& tracks,
                                     const CancellationToken& cancellation, CameraInitialization* cameras);

}  // namespace mlic
