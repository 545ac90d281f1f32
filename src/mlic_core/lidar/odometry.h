#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/lidar/deskew.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// LiDAR odometry of one LiDAR alone, after KISS-ICP (Vizzo et al., RA-L 2023): constant-velocity de-skew,
// adaptive threshold, voxel hash map, robust registration. docs/method.md, section 5.

// T_odom_lidar at time `time` (seconds since the drive's epoch, LiDAR clock): the middle of the scan.
struct OdometryPose {
  double time = 0.0;
  RigidTransform pose;
  double residual_rms = 0.0;  // of the last registration, inliers, m
  double inlier_share = 0.0;  // matched share of the keypoints
};

struct OdometryResult {
  std::vector<OdometryPose> poses;  // one for each scan, in order; the first is the identity
};

OdometryResult RunOdometry(const LidarRecording& recording, const RotationBetween& rotation_between,
                           const CancellationToken& cancellation,
                           const std::function<void(double fraction)>& on_progress);

}  // namespace mlic
