#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "mlic_core/problem/linear_terms.h"
#include "mlic_core/solver/normal_equations.h"

namespace mlic {

// The joint problem linearised at a solution, with control points and landmarks eliminated: what the measures
// of uncertainty share. Couplings of points are cut short as in the solve (time_windows.h).
struct LinearizedProblem {
  // state must outlive this.
  LinearizedProblem(const JointProblem& given, const CalibrationState& state);

  LinearizationPoint At() const { return {problem, state, layout}; }

  std::vector<std::vector<std::size_t>> origins;  // of each drive's split points, the whole ones
  std::vector<std::size_t> whole_points;          // of each drive: how many before they were split
  JointProblem problem;
  const CalibrationState& state;
  Layout layout;
  std::vector<LandmarkCoupling> couplings;    // as Linearize gives them
  std::optional<ReducedEquations> equations;  // none: the trajectory is held, or they have no solution
};

}  // namespace mlic
