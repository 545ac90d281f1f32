#include "mlic_core/problem/inverse_in_limits.h"

#include <algorithm>

#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {

Eigen::MatrixXd InverseInLimits(const Eigen::MatrixXd& information, const Eigen::VectorXd& limits) {
  const Eigen::MatrixXd scaled = limits.asDiagonal() * information * limits.asDiagonal();
  const SymmetricEigen<Eigen::Dynamic> eigen(0.5 * (scaled + scaled.transpose()));
  const double largest = std::max(1.0, eigen.eigenvalues().maxCoeff());
  const Eigen::VectorXd inverse = eigen.eigenvalues().unaryExpr(
      [&](double v) { return 1.0 / std::max(v, std::max(1e-12, 1e-15 * largest)); });
  const Eigen::MatrixXd covariance =
      eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
  return limits.asDiagonal() * covariance * limits.asDiagonal();
}

}  // namespace mlic
