#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/lidar/deskew.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// LiDAR odometry of one LiDAR alone, after KISS-ICP (Vizzo et al., RA-L 2023): constant-velocity de-skew,
// adaptive threshold, voxel hash map, robust registration. docs/method.md, section 5.

// T_odom_lidar in the middle of each scan (LiDAR clock), in order; the first is the identity.
std::vector<TimedPose> RunOdometry(const LidarRecording& recording, const InertialMotion& inertial,
                                   const CancellationToken& cancellation,
                                   const std::function<void(double fraction)>& on_progress);

}  // namespace mlic
