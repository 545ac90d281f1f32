#pragma once

#include <Eigen/Core>

#include "mlic_core/common/progress.h"
#include "mlic_core/problem/linearized_problem.h"

namespace mlic {

// What of SolveSummary::information is not the motion's but the trajectory's noise: the Jacobians are taken
// at an estimate of the trajectory, and what shakes in it looks like motion. A gyroscope's noise about the
// level axes of a car on flat ground seems to show the height of its sensors. Measured by linearising at
// trajectories that are drawn about the estimate from its own covariance: by so much as they show more, the
// estimate shows more than the truth. Positive semidefinite, calibration x calibration; the same for the same
// problem. Zero where the equations have no solution, or the trajectory is held. docs/method.md, section 11.
Eigen::MatrixXd NoiseInformation(const LinearizedProblem& linearized, const CancellationToken& cancellation);

// The information that belongs to the errors of an estimate made with `information`, of which `noise` is
// noise's: S_t S^-1 S_t with S_t = S - noise, as the gradient's covariance is S and only S_t pulls. limits:
// steps of the parameters that count as large.
Eigen::MatrixXd WithoutNoise(const Eigen::MatrixXd& information, const Eigen::MatrixXd& noise,
                             const Eigen::VectorXd& limits);

}  // namespace mlic
