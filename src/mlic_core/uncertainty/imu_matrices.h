#pragma once

#include "mlic_core/problem/joint_solver.h"

namespace mlic {

// What a drive says of scale and shear of its IMU.
struct MatrixEvidence {
  double sigma = 0.0;  // of their entries, as the data have it; 0: they show none
  double gain = 0.0;   // twice the logarithm of the likelihood's ratio to an IMU without such errors

  // Beyond five sigmas: errors of lenses and readouts, which a car's little pitch hardly shows, reach four.
  bool IsShown() const { return gain > 25.0; }
};

// The entries of both triangles (Layout) as draws from a normal distribution about none, whose sigma is the
// unknown: the likelihood's maximum over it, all else of the calibration left free (empirical Bayes;
// docs/method.md, section 10). scale: of the variances. None where no matrices were probed.
MatrixEvidence EvidenceOfMatrices(const JointProblem& problem, const CalibrationState& state,
                                  const CalibrationEquations& probe, double scale);

// What the doubt of scale and shear that are held adds to the solve's equations, as Inflation::points has it:
// the mean of the entries' products, given the data, over all sigmas that data sheets have, weighed by their
// likelihood. What a drive does not show of one entry (the shear that turns a car's heading) it has of the
// others' size. Zero where they are estimated, and where no matrices were probed.
Eigen::MatrixXd ScatterOfMatrices(const JointProblem& problem, const CalibrationState& state,
                                  const CalibrationEquations& probe, double scale);

}  // namespace mlic
