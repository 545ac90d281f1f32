#pragma once

#include <Eigen/Core>

namespace mlic {

// Decompositions of symmetric matrices, compiled once for all who use them: each size for which a file
// instantiates Eigen's templates costs it 4 to 10 s of compilation.

// Eigenvalues in ascending order and the eigenvectors, as columns of unit length. Only the lower triangle is
// read. Size: 3 or Eigen::Dynamic, which takes any size.
template <int Size>
class SymmetricEigen {
 public:
  using Matrix = Eigen::Matrix<double, Size, Size>;
  using Vector = Eigen::Matrix<double, Size, 1>;

  explicit SymmetricEigen(const Matrix& symmetric);

  const Vector& eigenvalues() const { return eigenvalues_; }
  const Matrix& eigenvectors() const { return eigenvectors_; }

 private:
  Vector eigenvalues_;
  Matrix eigenvectors_;
};

extern template class SymmetricEigen<3>;
extern template class SymmetricEigen<Eigen::Dynamic>;

// X of A X = B by Cholesky decomposition with pivoting. A: n x n, symmetric, positive or negative
// semidefinite; B: n x m.
Eigen::MatrixXd SolveSymmetric(const Eigen::Ref<const Eigen::MatrixXd>& A,
                               const Eigen::Ref<const Eigen::MatrixXd>& B);
// x^T A^-1 x: where A is a covariance, the squared Mahalanobis distance. A: n x n, x: n.
double SquaredMahalanobis(const Eigen::Ref<const Eigen::MatrixXd>& A,
                          const Eigen::Ref<const Eigen::VectorXd>& x);
// SolveSymmetric of 3 x 3, without memory of its own: for inner loops.
Eigen::Vector3d SolveSymmetric3(const Eigen::Matrix3d& A, const Eigen::Vector3d& b);

}  // namespace mlic
