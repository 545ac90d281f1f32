#pragma once

#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// Moves each point landmark of the problem, one by itself, to where its observations have it, all else held.
// After a long step of the cameras points that took the linear step are far off their rays: a change of scale
// moves them all. Jeong et al., "Pushing the envelope of modern methods for bundle adjustment", PAMI 2012
// (embedded point iterations).
// before: where the landmarks were before the step.
void SettlePoints(const CalibrationState& state, const Layout& layout,
                  const std::vector<LandmarkGeometry>& before, JointProblem* problem);

}  // namespace mlic
