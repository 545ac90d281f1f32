#pragma once

#include <Eigen/Core>

#include "mlic_core/common/progress.h"
#include "mlic_core/problem/linearized_problem.h"

namespace mlic {

// What of SolveSummary::information is not the motion's but the noise of trajectory and planes: the Jacobians
// are taken at an estimate of them, and what shakes in it looks like motion, or like surfaces that face other
// ways. A gyroscope's noise about the level axes of a car on flat ground seems to show the height of its
// sensors, and so do small patches of vertical walls that two LiDARs share. Measured by linearising at
// trajectories and planes that are drawn about the estimate from its own covariance: by so much as they show
// more, the estimate shows more than the truth. Positive semidefinite, calibration x calibration; the same
// for the same problem. Zero where the equations have no solution, or the trajectory is held. docs/method.md,
// section 11.
Eigen::MatrixXd NoiseInformation(const LinearizedProblem& linearized, const CancellationToken& cancellation);

// Normal equations that put an estimate as far off as those of an information S do of which a part is the
// noise's. Only S_t = S - noise pulls: a gradient g of covariance S puts it off by S_t^-1 g, which is what
// the gradient A g with A = S_t S^-1 and its covariance A S A^T do, taken for gradient and information.
struct FreedOfNoise {
  Eigen::MatrixXd information;  // A S A^T = S_t S^-1 S_t
  Eigen::MatrixXd by_gradient;  // A
};

// limits: steps of the parameters that count as large.
FreedOfNoise WithoutNoise(const Eigen::MatrixXd& information, const Eigen::MatrixXd& noise,
                          const Eigen::VectorXd& limits);

}  // namespace mlic
