#pragma once

#include "mlic_core/common/progress.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// A rival to compare with: each sensor by its own motion against the IMU's, the rig's guesses as priors; no
// common map, no joint solve. docs/method.md, section 13. LiDARs as the calibration initialises them:
// odometry of each, the base LiDAR to the raw IMU, hand-eye of the others to the trajectory that these two
// give. Cameras on this trajectory: rotation and time offset from their visual rotations, then the position
// from the directions of their motions; intrinsics are those of `lenses`. Poses, time offsets and intrinsics
// only, no sigmas; sensors whose motion does not agree with the IMU's are among the rejected. InputError for
// a rig without a LiDAR: nothing then gives the motion's scale.
CalibrationResult CalibrateByHandEye(const Rig& rig, const Dataset& dataset, const CalibrationResult& lenses,
                                     const CancellationToken& cancellation);

}  // namespace mlic
