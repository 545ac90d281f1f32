#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// Equations of some parameters from the data alone, others that move beside them followed.
struct MarginalEquations {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

// data, gradient: of all parameters. prior, prior_gradient: what is known of them beside the data; that of
// the others counts. limits: steps that count as large.
MarginalEquations MarginalOf(const std::vector<int>& parameters, const std::vector<int>& others,
                             const Eigen::MatrixXd& data, const Eigen::VectorXd& gradient,
                             const Eigen::MatrixXd& prior, const Eigen::VectorXd& prior_gradient,
                             const Eigen::VectorXd& limits);

}  // namespace mlic
