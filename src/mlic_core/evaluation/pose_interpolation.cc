#include "mlic_core/evaluation/pose_interpolation.h"

#include <algorithm>

namespace mlic {

bool InterpolatePose(const std::vector<StampedPose>& trajectory, TimeNs time, std::size_t* next,
                     RigidTransform* pose) {
  const auto after = [](TimeNs t, const StampedPose& p) { return t < p.time; };
  std::size_t upper = *next;
  if (upper == 0 || upper >= trajectory.size() || trajectory[upper - 1].time > time ||
      trajectory[upper].time <= time) {
    upper = static_cast<std::size_t>(std::upper_bound(trajectory.begin(), trajectory.end(), time, after) -
                                     trajectory.begin());
  }
  if (upper == 0 || upper == trajectory.size()) return false;
  *next = upper;
  const StampedPose &a = trajectory[upper - 1], &b = trajectory[upper];
  const double u = static_cast<double>(time - a.time) / static_cast<double>(b.time - a.time);
  pose->rotation = a.pose.rotation.slerp(u, b.pose.rotation);
  pose->translation = (1.0 - u) * a.pose.translation + u * b.pose.translation;
  return true;
}

}  // namespace mlic
