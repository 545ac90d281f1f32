#include "mlic_core/geometry/symmetric_matrix.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/wahba.h"

namespace mlic::symmetric_matrix_test {
namespace {

Eigen::MatrixXd Draw(int rows, int columns, Random* random) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&]() { return random->Normal(); });
}

TEST(SymmetricMatrix, IsTakenApartIntoOrderedEigenvaluesAndUnitVectors) {
  Random random(1);
  for (const int n : {1, 2, 3, 9, 40}) {
    const Eigen::MatrixXd half = Draw(n, n, &random), A = half + half.transpose();
    const SymmetricEigen<Eigen::Dynamic> eigen(A);
    const Eigen::MatrixXd& V = eigen.eigenvectors();
    EXPECT_LT((V * eigen.eigenvalues().asDiagonal() * V.transpose() - A).norm(), 1e-12 * A.norm() * n);
    EXPECT_LT((V.transpose() * V - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-12 * n);
    for (int i = 1; i < n; ++i) EXPECT_LE(eigen.eigenvalues()[i - 1], eigen.eigenvalues()[i]);
  }
  const Eigen::MatrixXd half = Draw(3, 3, &random), A = half + half.transpose();
  EXPECT_LT((SymmetricEigen<3>(A).eigenvalues() - SymmetricEigen<Eigen::Dynamic>(A).eigenvalues()).norm(),
            1e-12);
}

TEST(SymmetricMatrix, SolvesForEachColumnAlsoWhereNegative) {
  Random random(2);
  for (const int n : {2, 3, 12}) {
    for (const double sign : {1.0, -1.0}) {
      const Eigen::MatrixXd half = Draw(n, 2 * n, &random), A = sign * half * half.transpose();
      const Eigen::MatrixXd B = Draw(n, 4, &random), X = SolveSymmetric(A, B);
      EXPECT_LT((A * X - B).norm(), 1e-11 * B.norm() * n);
      EXPECT_NEAR(SquaredMahalanobis(A, B.col(0)), B.col(0).dot(A.inverse() * B.col(0)),
                  1e-10 * X.col(0).norm() * B.col(0).norm());
      if (n != 3) continue;
      EXPECT_LT((SolveSymmetric3(A, B.col(1)) - X.col(1)).norm(), 1e-11 * X.col(1).norm());
    }
  }
}

TEST(Wahba, GivesTheRotationAlsoWhereAReflectionFitsBetter) {
  Random random(3);
  const Eigen::Matrix3d R = ExpMatrix(Eigen::Vector3d(0.3, -1.1, 2.0));
  const Eigen::Matrix3d of_plane =
      Eigen::Vector3d(2.0, 1.0, -0.1).asDiagonal();  // mirrored points near a plane
  double fit = 0.0;
  EXPECT_LT((WahbaRotation(R * of_plane, &fit) - R).norm(), 1e-12);
  EXPECT_NEAR(fit, 2.9, 1e-12);
}

}  // namespace
}  // namespace mlic::symmetric_matrix_test
