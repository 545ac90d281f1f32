#include "mlic_core/imu/relative_motion.h"

#include <cmath>

#include "mlic_core/imu/pose_segments.h"

namespace mlic {

std::vector<RelativeMotion> RelativeMotions(const SplitSpline& T_map_imu,
                                            const std::vector<TimedPose>& T_odom_lidar, double time_offset,
                                            double interval) {
  const std::vector<TimedPose> poses = OrderedFinitePoses(T_odom_lidar);
  std::vector<RelativeMotion> motions;
  std::size_t to = 0;
  for (std::size_t from = 0; from < poses.size(); ++from) {
    const auto miss = [&](std::size_t k) { return std::abs(poses[k].time - poses[from].time - interval); };
    while (to + 1 < poses.size() && miss(to + 1) <= miss(to)) ++to;
    const double start = poses[from].time + time_offset;
    const double end = poses[to].time + time_offset;
    if (to <= from || miss(to) > 0.5 * interval || !T_map_imu.Contains(start) || !T_map_imu.Contains(end))
      continue;
    RelativeMotion motion;
    motion.imu = T_map_imu.Pose(start).Inverse() * T_map_imu.Pose(end);
    motion.lidar = poses[from].pose.Inverse() * poses[to].pose;
    motions.push_back(motion);
  }
  return motions;
}

}  // namespace mlic
