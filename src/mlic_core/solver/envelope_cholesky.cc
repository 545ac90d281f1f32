#include "mlic_core/solver/envelope_cholesky.h"

#include <algorithm>

#include "mlic_core/common/parallel.h"
#include "mlic_core/solver/blas.h"

namespace mlic {

EnvelopeMatrix::EnvelopeMatrix(std::vector<int> reach, int border_rows)
    : border(Eigen::MatrixXd::Zero(border_rows, reach.size())), size_(static_cast<int>(reach.size())) {
  std::size_t begin = 0;
  int end = 0;
  for (int first = 0; first < size_; first += kTile) {
    const int next = std::min(size_, first + kTile);
    for (int j = first; j < next; ++j) end = std::max(end, std::min(size_, std::max(j, reach[j]) + 1));
    const int last_tile = (end - 1) / kTile;
    const int height = std::min(size_, (last_tile + 1) * kTile) - first;
    panels_.push_back({begin, height, next - first, last_tile});
    begin += static_cast<std::size_t>(height) * (next - first);
  }
  values_.assign(begin, 0.0);
}

// Rows below the diagonal tile, and the border's: times L_kk^-T.
void EnvelopeMatrix::DivideBelow(std::size_t k) {
  constexpr int kRows = 256;  // from: structural, speed only
  const Panel& panel = panels_[k];
  double* diagonal = values_.data() + panel.begin;
  const double one = 1.0;
  const int below = panel.height - panel.width;
  const int parts = (below + kRows - 1) / kRows;
  ParallelFor(parts + 1, [&](std::size_t part) {
    const bool of_border = static_cast<int>(part) == parts;
    const int begin = static_cast<int>(part) * kRows;
    const int rows = of_border ? static_cast<int>(border.rows()) : std::min(kRows, below - begin);
    if (rows == 0) return;
    double* target = of_border ? &border(0, k * kTile) : diagonal + panel.width + begin;
    const int stride = of_border ? rows : panel.height;
    dtrsm_("R", "L", "T", "N", &rows, &panel.width, &one, diagonal, &panel.height, target, &stride);
  });
}

// Takes what columns k explain out of the columns of a later tile.
void EnvelopeMatrix::UpdateTile(std::size_t k, std::size_t tile) {
  const Panel& from = panels_[k];
  const Panel& to = panels_[tile];
  const int skipped = static_cast<int>(tile - k) * kTile;
  const double* rows = values_.data() + from.begin + skipped;
  const BlasView<const double> of_tile{rows, to.width, from.width, from.height};
  SubtractTransposedProduct({rows, from.height - skipped, from.width, from.height}, of_tile,
                            {values_.data() + to.begin, from.height - skipped, to.width, to.height});
  const int border_rows = static_cast<int>(border.rows());
  if (border_rows == 0) return;
  SubtractTransposedProduct({&border(0, k * kTile), border_rows, from.width, border_rows}, of_tile,
                            {&border(0, tile * kTile), border_rows, to.width, border_rows});
}

bool EnvelopeMatrix::Factor() {
  const BlasOnOneThread guard;
  for (std::size_t k = 0; k < panels_.size(); ++k) {
    const Panel& panel = panels_[k];
    int info = 0;
    dpotrf_("L", &panel.width, values_.data() + panel.begin, &panel.height, &info);
    if (info != 0) return false;
    DivideBelow(k);
    ParallelFor(panel.last_tile - k, [&](std::size_t i) { UpdateTile(k, k + 1 + i); });
  }
  return true;
}

void EnvelopeMatrix::SolveTransposed(Eigen::VectorXd* right) const {
  for (std::size_t k = panels_.size(); k-- > 0;) {
    const Panel& panel = panels_[k];
    const Eigen::Map<const Eigen::MatrixXd> L(values_.data() + panel.begin, panel.height, panel.width);
    auto x = right->segment(k * kTile, panel.width);
    const int below = panel.height - panel.width;
    x.noalias() -= L.bottomRows(below).transpose() * right->segment(k * kTile + panel.width, below);
    L.topRows(panel.width).triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  }
}

void EnvelopeMatrix::SolveTransposedRows(Eigen::MatrixXd* rows) const {
  constexpr int kTogether = 16;  // from: structural, speed only
  const BlasOnOneThread guard;
  const int all = static_cast<int>(rows->rows());
  ParallelFor((all + kTogether - 1) / kTogether, [&](std::size_t part) {
    const int begin = static_cast<int>(part) * kTogether, count = std::min(kTogether, all - begin);
    const double one = 1.0, minus = -1.0;
    for (std::size_t k = panels_.size(); k-- > 0;) {
      const Panel& panel = panels_[k];
      const double* diagonal = values_.data() + panel.begin;
      double* target = &(*rows)(begin, k * kTile);
      const int below = panel.height - panel.width;
      if (below > 0) {
        dgemm_("N", "N", &count, &panel.width, &below, &minus,
               target + static_cast<std::size_t>(panel.width) * all, &all, diagonal + panel.width,
               &panel.height, &one, target, &all);
      }
      dtrsm_("R", "L", "N", "N", &count, &panel.width, &one, diagonal, &panel.height, target, &all);
    }
  });
}

}  // namespace mlic
