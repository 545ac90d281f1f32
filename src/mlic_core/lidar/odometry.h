#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/lidar/deskew.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// LiDAR odometry of one LiDAR alone, after KISS-ICP (Vizzo et al., RA-L 2023): constant-velocity de-skew,
// adaptive threshold, voxel hash map, robust registration. docs/method.md, section 5.

constexpr std::size_t kAllScans = std::numeric_limits<std::size_t>::max();  // from: structural

// T_odom_lidar in the middle of each scan (LiDAR clock), in order; the first is the identity. remembered: how
// many scans the map holds at most. Where scans cannot all be followed, a map that forgets soon is without
// the ones that went wrong; it drifts more.
std::vector<TimedPose> RunOdometry(const LidarRecording& recording, const InertialMotion& inertial,
                                   std::size_t remembered, const CancellationToken& cancellation,
                                   const std::function<void(double fraction)>& on_progress);

}  // namespace mlic
