#include "mlic_core/uncertainty/marginal_equations.h"

#include "mlic_core/problem/inverse_in_limits.h"
#include "mlic_core/solver/submatrix.h"

namespace mlic {

MarginalEquations MarginalOf(const std::vector<int>& parameters, const std::vector<int>& others,
                             const Eigen::MatrixXd& data, const Eigen::VectorXd& gradient,
                             const Eigen::MatrixXd& prior, const Eigen::VectorXd& prior_gradient,
                             const Eigen::VectorXd& limits) {
  const Eigen::MatrixXd cross = Submatrix(data, parameters, others);
  const Eigen::MatrixXd followed =
      cross * InverseInLimits(Submatrix(data + prior, others), SelectRows(limits, others));
  return {Submatrix(data, parameters) - followed * cross.transpose(),
          SelectRows(gradient, parameters) - followed * SelectRows(gradient + prior_gradient, others)};
}

}  // namespace mlic
