#pragma once

#include <Eigen/Core>

namespace mlic {

// Inverse of an information matrix whose directions may carry nothing: in units of the limits (one for each
// parameter), no direction is known worse than a million limits.
Eigen::MatrixXd InverseInLimits(const Eigen::MatrixXd& information, const Eigen::VectorXd& limits);

}  // namespace mlic
