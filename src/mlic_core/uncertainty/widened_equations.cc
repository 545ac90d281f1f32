#include "mlic_core/uncertainty/widened_equations.h"

#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {

void Widen(Eigen::Index more, Accumulator* sum, std::vector<LandmarkCoupling>* couplings) {
  const Eigen::Index old = sum->corner.rows(), wide = old + more;
  const auto widen_rows = [&](auto* matrix) {
    matrix->conservativeResize(wide, matrix->cols());
    matrix->bottomRows(more).setZero();
  };
  widen_rows(&sum->border);
  widen_rows(&sum->gradient_calibration);
  sum->corner.conservativeResize(wide, wide);
  sum->corner.bottomRows(more).setZero();
  sum->corner.rightCols(more).setZero();
  for (LandmarkCoupling& coupling : *couplings) widen_rows(&coupling.calibration);
}

Eigen::MatrixXd PartOfCovariance(Eigen::MatrixXd information, const std::vector<bool>& free,
                                 Eigen::Index begin, Eigen::Index count) {
  const Eigen::Index size = information.rows();
  for (Eigen::Index i = 0; i < size; ++i) {
    if (free[i]) continue;
    information.row(i).setZero();
    information.col(i).setZero();
    information(i, i) = 1.0;
  }
  const Eigen::MatrixXd part = Eigen::MatrixXd::Identity(size, size).middleCols(begin, count);
  Eigen::MatrixXd covariance = SolveSymmetric(information, part).middleRows(begin, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!free[begin + i]) covariance(i, i) = 0.0;
  }
  return covariance;
}

}  // namespace mlic
