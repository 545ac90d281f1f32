#pragma once

#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// Motions of IMU and LiDAR over the same interval [t1, t2]: T_imu(t1)_imu(t2) and T_lidar(t1)_lidar(t2), with
// the sigmas (per component, radians and metres) of their disagreement; only the ratios between motions
// matter.
struct RelativeMotion {
  RigidTransform imu;
  RigidTransform lidar;
  double sigma_rotation = 2e-3;
  double sigma_translation = 1e-2;
};

// Motions between poses about `interval` seconds apart (every pose starts one) that the IMU's trajectory
// covers, where IMU time is pose time + time_offset. Sigmas are the defaults. Pairs more than half an
// interval off are left out.
std::vector<RelativeMotion> RelativeMotions(const SplitSpline& T_map_imu,
                                            const std::vector<TimedPose>& T_odom_lidar, double time_offset,
                                            double interval);

}  // namespace mlic
