#pragma once

#include "mlic_sim/trajectory.h"
#include "support/spline_through.h"

namespace mlic {

// A simulated drive's true trajectory as the spline that the core works with. A spline with the poses as
// control points is off by acceleration * spacing^2 / 6: micrometres at 2 ms. spacing: s.
inline SplitSpline TrueSpline(const sim::Trajectory& trajectory, double duration, double spacing = 0.002) {
  return SplineThrough(UniformKnots::Covering(0.0, duration, spacing),
                       [&](double time) { return trajectory.PoseAt(time); });
}

}  // namespace mlic
