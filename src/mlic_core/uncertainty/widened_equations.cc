#include "mlic_core/uncertainty/widened_equations.h"

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

void HoldFixed(const std::vector<bool>& free, Eigen::MatrixXd* information) {
  for (Eigen::Index i = 0; i < information->rows(); ++i) {
    if (free[static_cast<std::size_t>(i)]) continue;
    information->row(i).setZero();
    information->col(i).setZero();
    (*information)(i, i) = 1.0;
  }
}

}  // namespace mlic
