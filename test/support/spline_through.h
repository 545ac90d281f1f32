#pragma once

#include <utility>
#include <vector>

#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// Has the poses at the control points' times as control points. pose_at: of a time, s.
template <typename PoseAt>
SplitSpline SplineThrough(const UniformKnots& knots, const PoseAt& pose_at) {
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> positions;
  for (int j = 0; j < knots.count; ++j) {
    const RigidTransform pose = pose_at(knots.ControlPointTime(j));
    rotations.push_back(pose.rotation);
    positions.push_back(pose.translation);
  }
  return {So3Spline(knots, std::move(rotations)), PositionSpline(knots, std::move(positions))};
}

}  // namespace mlic
