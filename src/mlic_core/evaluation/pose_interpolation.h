#pragma once

#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// Pose of a trajectory in order of time, by the two neighbours (linear and slerp); false outside it. `next`
// is a hint, moved along as times grow; begin with 0.
bool InterpolatePose(const std::vector<StampedPose>& trajectory, TimeNs time, std::size_t* next,
                     RigidTransform* pose);

// Halfway from its first to its last pose, where time offsets hold; it must have poses.
inline TimeNs MiddleOf(const std::vector<StampedPose>& trajectory) {
  return trajectory.front().time + (trajectory.back().time - trajectory.front().time) / 2;
}

}  // namespace mlic
