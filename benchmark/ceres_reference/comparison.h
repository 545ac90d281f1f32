#pragma once

#include <Eigen/Core>

#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/state.h"

namespace mlic::ceres_reference {

// From b to a in the tangent space of b, in order of Layout.
Eigen::VectorXd CalibrationDifference(const Layout& layout, const CalibrationState& a,
                                      const CalibrationState& b);

// The inverse of what the data (information, as SolveJointProblem gives it) and the priors at the state say
// about what the problem lets move; zeros for what is fixed.
Eigen::MatrixXd CalibrationCovariance(const JointProblem& problem, const CalibrationState& state,
                                      const Eigen::MatrixXd& information);

// Largest change of a free parameter by its sigma.
double LargestInSigmas(const Eigen::VectorXd& difference, const Eigen::MatrixXd& covariance);

// The problem with points cut by time already, so that solving it once more goes on where the last solve
// ended.
JointProblem WithPointsCut(JointProblem problem, const CalibrationState& state);

// SolveJointProblem from where it left off, landmarks included.
SolveSummary ContinueSolve(int iterations, JointProblem* problem, CalibrationState* state);

struct OwnMinimum {
  CalibrationState state;
  JointProblem problem;  // its landmarks at the minimum
  Eigen::MatrixXd covariance;
  double first_cost;   // of the data, sum of squares
  double last_change;  // of the calibration by the last solve, sigmas
};

// The own solver again and again until the calibration stands still to 1e-5 sigma, 40 times at most: by
// itself it ends once a step lowers the cost by less than a ten thousandth.
OwnMinimum FindOwnMinimum(const JointProblem& problem, const CalibrationState& start);

}  // namespace mlic::ceres_reference
