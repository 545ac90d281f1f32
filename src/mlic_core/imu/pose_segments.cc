#include "mlic_core/imu/pose_segments.h"

#include <cmath>

namespace mlic {

std::vector<PoseSegment> CutSegments(const std::vector<TimedPose>& poses, const GyroIntegration& gyro,
                                     double time_offset) {
  constexpr int kFewestPoses = 6;  // from: guard
  std::vector<PoseSegment> segments;
  const int count = static_cast<int>(poses.size());
  for (int begin = 0; begin < count;) {
    const double start = poses[begin].time + time_offset;
    int end = begin;
    while (end < count && poses[end].time + time_offset - start <= kSegmentLength &&
           gyro.Covers(start, poses[end].time + time_offset)) {
      ++end;
    }
    if (end - begin >= kFewestPoses) segments.push_back({begin, end});
    begin = std::max(end, begin + 1);
  }
  return segments;
}

std::vector<TimedPose> OrderedFinitePoses(const std::vector<TimedPose>& poses) {
  std::vector<TimedPose> kept;
  kept.reserve(poses.size());
  for (const TimedPose& pose : poses) {
    if (!std::isfinite(pose.time) || !pose.pose.translation.allFinite() ||
        !pose.pose.rotation.coeffs().allFinite()) {
      continue;
    }
    if (!kept.empty() && pose.time <= kept.back().time) continue;
    kept.push_back(pose);
  }
  return kept;
}

}  // namespace mlic
