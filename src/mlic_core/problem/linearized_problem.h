#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mlic_core/problem/linear_terms.h"

namespace mlic {

// A deviation of trajectory and planes drawn from the normal distribution that the equations give them with
// the calibration held, the same for the same equations.
struct NoiseDraw {
  Eigen::VectorXd step;  // laid out as Layout, zero for the calibration
  // The landmarks' best steps (linearizer.h) beside this step, and beside its opposite; planes with a
  // deviation of their own, and its opposite.
  std::vector<Eigen::Vector3d> landmarks, landmarks_of_opposite;
};

// The joint problem linearised at a solution, with control points and landmarks eliminated: what the measures
// of uncertainty share. Couplings of points are cut short as in the solve (time_windows.h). The equations
// themselves, which are as large as all else together, are not kept.
struct LinearizedProblem {
  // state must outlive this.
  LinearizedProblem(const JointProblem& given, const CalibrationState& state);

  LinearizationPoint At() const { return {problem, state, layout}; }

  std::vector<std::vector<std::size_t>> origins;  // of each drive's split points, the whole ones
  std::vector<std::size_t> whole_points;          // of each drive: how many before they were split
  JointProblem problem;
  const CalibrationState& state;
  Layout layout;
  bool solved = false;            // if not, the trajectory is held, or the equations have no solution
  Eigen::MatrixXd information;    // of the calibration, as in NormalSolution
  Eigen::MatrixXd knot_response;  // calibration x knots, as in ReducedEquations
  NoiseDraw draw;
};

}  // namespace mlic
