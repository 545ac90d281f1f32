#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// The equations of the calibration (Layout), trajectory and landmarks left free: where it would go, also what
// is held of it. Empty: there are none.
struct CalibrationEquations {
  Eigen::MatrixXd information;     // as SolveSummary's
  Eigen::VectorXd gradient;        // of the data
  Eigen::VectorXd prior_gradient;  // of all else
};

struct SolveSummary {
  bool solved = false;  // some iteration's equations had a solution; else the state is as it was given
  int iterations = 0;
  double first_cost = 0.0;
  double last_cost = 0.0;
  std::size_t observations = 0;  // of points to planes
  std::size_t landmark_observations = 0;
  double last_step = 0.0;       // largest step of the calibration in the last iteration: m, rad
  Eigen::MatrixXd information;  // of the calibration, from the data alone, at the last linearisation
  // Of the calibration (Layout): what was not taken of the last undamped step, as it would have raised the
  // cost; empty: nothing. The minimum lies about that far off, whatever damped steps have moved.
  Eigen::VectorXd refused_step;
  // Of the last undamped step, with scale and shear of the IMU where the solve probed them, else empty.
  CalibrationEquations imu_matrices;
  std::vector<LandmarkGeometry> landmarks;  // of each drive, as the solve moved them
};

// Gauss-Newton. Of a step that does not lower the cost, not even with each point landmark settled by itself
// (SettlePoints), a half or a quarter is taken, and where that does not either, Marquardt damping follows: at
// most so many iterations, and no more once a step lowers the cost by next to nothing. A step that raises the
// cost, or after which it is not a number, is taken back, the last one too. Throws InternalError where the
// cost is not a number at the start. The result does not depend on the number of threads but for the rounding
// of the dense factorisation. probe_matrices: the equations carry the IMU's scale and shear, where the
// problem does not estimate them, and they do not move.
SolveSummary SolveJointProblem(const JointProblem& problem, int iterations,
                               const CancellationToken& cancellation, CalibrationState* state,
                               bool probe_matrices = false);

// At a state, which stays. Empty where they have no solution.
CalibrationEquations EquationsOfCalibration(const JointProblem& problem, const CalibrationState& state);

// Puts the problem's landmarks to where a solve of it has moved them.
void PlaceLandmarks(std::vector<LandmarkGeometry> landmarks, JointProblem* problem);

// Which calibration parameters (Layout) the problem lets move.
std::vector<bool> FreeCalibration(const JointProblem& problem, const Layout& layout);

}  // namespace mlic
