#pragma once

#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// One drive's trajectory and biases drawn to poses of the IMU and its samples, from a start. sigmas: of the
// poses (rad, m). By the joint problem's solver and not as a small fit: hundreds of control points, banded in
// time.
DriveState FitToPoses(const Drive& drive, const ImuSigma& imu_sigma, const std::vector<TimedPose>& poses,
                      double sigma_rotation, double sigma_translation, DriveState start);

}  // namespace mlic
