#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>

namespace mlic {

// How far a Jacobian may be off central differences.
struct JacobianTolerance {
  double step = 1e-6;       // in each unknown, either way
  double relative = 1e-5;   // of a column's norm,
  double least_norm = 1.0;  // which counts for this at least
};

// Expects that the first `columns` rows of J (one for each unknown; column k: of residual k) are the
// derivatives of the residuals. residual_at(column, step): the residuals, a vector, with one unknown moved.
template <typename Jacobian, typename ResidualAt>
void ExpectNumericJacobian(const Jacobian& J, int columns, const ResidualAt& residual_at,
                           const JacobianTolerance& tolerance = {}) {
  for (int c = 0; c < columns; ++c) {
    const Eigen::VectorXd ahead = residual_at(c, tolerance.step), behind = residual_at(c, -tolerance.step);
    const Eigen::VectorXd numeric = (ahead - behind) / (2.0 * tolerance.step);
    ASSERT_EQ(numeric.size(), J.cols());
    // Not the other way round: what is not a number must fail.
    EXPECT_LT((numeric - J.row(c).transpose()).norm(),
              tolerance.relative * (tolerance.least_norm + numeric.norm()))
        << "column " << c;
  }
}

}  // namespace mlic
