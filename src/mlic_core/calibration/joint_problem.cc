#include "mlic_core/calibration/joint_problem.h"

#include <algorithm>

#include "mlic_core/calibration/linearizer.h"

namespace mlic {

SolveSummary SolveJointProblem(const JointProblem& given, int iterations,
                               const CancellationToken& cancellation, CalibrationState* state) {
  JointProblem problem = given;  // the planes move with the solve
  const Layout layout(*state, problem.estimate_imu_matrices);
  std::vector<bool> free_calibration(layout.calibration, true);
  for (std::size_t i = 0; i < problem.lidar_held.size(); ++i) {
    if (problem.lidar_held[i]) std::fill_n(free_calibration.begin() + Layout::Lidar(i), 7, false);
  }
  if (problem.hold_trajectory) {
    std::fill(free_calibration.begin() + 7 * state->lidars.size(), free_calibration.end(), false);
  }
  SolveSummary summary;
  for (const PlaneAssociation& association : problem.planes)
    summary.observations += association.observations.size();
  std::vector<LandmarkTies> ties;
  const auto linearize = [&](const CalibrationState& at) { return Linearize({problem, at, layout}, &ties); };
  Eigen::MatrixXd prior;
  Eigen::VectorXd prior_gradient;
  Accumulator sum = linearize(*state);
  summary.first_cost = summary.last_cost = sum.cost;
  double damping = 0.0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    cancellation.ThrowIfCancelled();
    CalibrationPrior(problem, *state, layout, &prior, &prior_gradient);
    const NormalSolution solution = SolveNormalEquations(sum, ties, prior, prior_gradient, free_calibration,
                                                         damping, problem.hold_trajectory);
    ++summary.iterations;
    if (!solution.solved) {
      damping = std::max(1e-6, 10.0 * damping);
      continue;
    }
    summary.information = solution.information;
    CalibrationState moved = *state;
    const JointProblem before = problem;
    layout.Update(solution.delta, &moved);
    if (problem.hold_trajectory) moved.drives = state->drives;
    MoveLandmarks(ties, solution.delta, &problem);
    Accumulator next = linearize(moved);
    if (next.cost > sum.cost * (1.0 + 1e-3) + 1e-9 && iteration + 1 < iterations) {
      // Priors may rightly raise the data's cost a little; more than that is a step too far.
      problem = before;
      damping = std::max(1e-4, 10.0 * damping);
      sum = linearize(*state);
      continue;
    }
    damping *= 0.1;
    if (damping < 1e-6) damping = 0.0;
    *state = std::move(moved);
    summary.last_cost = next.cost;
    summary.last_step = solution.delta.segment(layout.knots, 7 * state->lidars.size()).cwiseAbs().maxCoeff();
    sum = std::move(next);
  }
  return summary;
}

}  // namespace mlic
