#pragma once

#include <vector>

#include "mlic_core/trajectory/split_spline.h"
#include "mlic_sim/trajectory.h"

namespace mlic {

// A simulated drive's true trajectory as the spline that the core works with. A spline with the poses as
// control points is off by acceleration * spacing^2 / 6: micrometres at 2 ms. spacing: s.
inline SplitSpline TrueSpline(const sim::Trajectory& trajectory, double duration, double spacing = 0.002) {
  const UniformKnots knots = UniformKnots::Covering(0.0, duration, spacing);
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> positions;
  for (int j = 0; j < knots.count; ++j) {
    const RigidTransform pose = trajectory.PoseAt(knots.ControlPointTime(j));
    rotations.push_back(pose.rotation);
    positions.push_back(pose.translation);
  }
  return {So3Spline(knots, std::move(rotations)), PositionSpline(knots, std::move(positions))};
}

}  // namespace mlic
