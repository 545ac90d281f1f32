#include "mlic_core/geometry/symmetric_matrix.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace mlic {

template <int Size>
SymmetricEigen<Size>::SymmetricEigen(const Matrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(symmetric);
  eigenvalues_ = eigen.eigenvalues();
  eigenvectors_ = eigen.eigenvectors();
}

template class SymmetricEigen<3>;
template class SymmetricEigen<Eigen::Dynamic>;

Eigen::MatrixXd SolveSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& A,
                               const Eigen::Ref<const Eigen::MatrixXd>& B) {
  return A.ldlt().solve(B);
}

double SquaredMahalanobis(const Eigen::Ref<const Eigen::MatrixXd>& A,
                          const Eigen::Ref<const Eigen::VectorXd>& x) {
  return x.dot(A.ldlt().solve(x));
}

Eigen::Vector3d SolveSymmetric3(const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  return A.ldlt().solve(b);
}

}  // namespace mlic
