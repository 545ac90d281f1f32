#include "mlic_core/solver/schur_complement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "mlic_core/common/parallel.h"
#include "mlic_core/solver/blas.h"

namespace mlic {
namespace {

constexpr int kTile = EnvelopeMatrix::kTile;  // from: structural

// Columns of tiles handled together: enough tasks for many cores, few rows in memory at once.
constexpr int kTogether = 16;  // from: structural, speed only

// own^-1 = root^T root.
Eigen::Matrix3d InverseRoot(const Eigen::Matrix3d& own) {
  Eigen::Matrix3d damped = own;
  damped.diagonal() *= 1.0 + 1e-12;
  damped.diagonal().array() += 1e-9;
  const Eigen::LLT<Eigen::Matrix3d> llt(damped);
  return llt.matrixL().solve(Eigen::Matrix3d::Identity());  // L^-1
}

std::vector<Eigen::Matrix3d> InverseRoots(const std::vector<LandmarkCoupling>& landmarks) {
  std::vector<Eigen::Matrix3d> roots(landmarks.size());
  ParallelFor(roots.size(), [&](std::size_t i) { roots[i] = InverseRoot(landmarks[i].own); });
  return roots;
}

// What calibration and gradient (last row) have to do with a landmark, by its inverse root.
void FillBorderRows(const LandmarkCoupling& landmark, const Eigen::Matrix3d& root,
                    Eigen::Ref<Eigen::MatrixXd> rows) {
  rows.topRows(landmark.calibration.rows()).noalias() = landmark.calibration * root.transpose();
  rows.bottomRows<1>() = (root * landmark.gradient).transpose();
}

void SubtractFromCorner(const std::vector<LandmarkCoupling>& landmarks,
                        const std::vector<Eigen::Matrix3d>& roots, Eigen::MatrixXd* corner) {
  constexpr std::size_t kParts = 16;  // from: structural, parts of a sum
  const BlasOnOneThread guard;
  const int border = static_cast<int>(corner->rows());
  std::vector<Eigen::MatrixXd> sums(kParts, Eigen::MatrixXd::Zero(border, border));
  ParallelFor(kParts, [&](std::size_t part) {
    const std::size_t begin = landmarks.size() * part / kParts, end = landmarks.size() * (part + 1) / kParts;
    Eigen::MatrixXd rows(border, 3 * (end - begin));
    for (std::size_t i = begin; i < end; ++i) {
      FillBorderRows(landmarks[i], roots[i], rows.middleCols<3>(3 * (i - begin)));
    }
    const BlasView<const double> all{rows.data(), border, static_cast<int>(rows.cols()), border};
    SubtractTransposedProduct(all, all, {sums[part].data(), border, border, border});
  });
  for (const Eigen::MatrixXd& sum : sums) *corner += sum;
}

// The couplings of one tile of control points to the landmarks that are seen there, by the landmarks' inverse
// roots: three columns for each landmark.
struct TileRows {
  std::vector<int> landmarks;  // ascending
  Eigen::MatrixXd rows;        // kTile, or fewer in the last tile
};

std::vector<TileRows> LandmarksOfTiles(const std::vector<LandmarkCoupling>& landmarks, int tiles) {
  std::vector<TileRows> of_tiles(tiles);
  std::vector<int> last(tiles, -1);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    for (const int column : landmarks[i].columns) {
      const int tile = column / kTile, landmark = static_cast<int>(i);
      if (last[tile] == landmark) continue;
      last[tile] = landmark;
      of_tiles[tile].landmarks.push_back(landmark);
    }
  }
  return of_tiles;
}

void FillRows(const std::vector<LandmarkCoupling>& landmarks, const std::vector<Eigen::Matrix3d>& roots,
              int tile, int height, TileRows* of_tile) {
  of_tile->rows = Eigen::MatrixXd::Zero(height, 3 * of_tile->landmarks.size());
  for (std::size_t k = 0; k < of_tile->landmarks.size(); ++k) {
    const LandmarkCoupling& landmark = landmarks[of_tile->landmarks[k]];
    const Eigen::Matrix3d& root = roots[of_tile->landmarks[k]];
    for (std::size_t b = 0; b < landmark.columns.size(); ++b) {
      if (landmark.columns[b] / kTile != tile) continue;
      of_tile->rows.block<3, 3>(landmark.columns[b] - tile * kTile, 3 * k).noalias() =
          landmark.blocks[b] * root.transpose();
    }
  }
}

// A tile of A -= a * b^T over the landmarks that both tiles of control points see.
void SubtractProduct(const TileRows& a, const TileRows& b, double* target, int stride) {
  const int height = static_cast<int>(a.rows.rows()), width = static_cast<int>(b.rows.rows());
  std::vector<std::pair<int, int>> shared;
  for (std::size_t i = 0, k = 0; i < a.landmarks.size() && k < b.landmarks.size();) {
    if (a.landmarks[i] < b.landmarks[k]) {
      ++i;
    } else if (a.landmarks[i] > b.landmarks[k]) {
      ++k;
    } else {
      shared.emplace_back(i++, k++);
    }
  }
  if (shared.empty()) return;
  Eigen::MatrixXd left(height, 3 * shared.size()), right(width, 3 * shared.size());
  for (std::size_t s = 0; s < shared.size(); ++s) {
    left.middleCols<3>(3 * s) = a.rows.middleCols<3>(3 * shared[s].first);
    right.middleCols<3>(3 * s) = b.rows.middleCols<3>(3 * shared[s].second);
  }
  const int inner = static_cast<int>(left.cols());
  SubtractTransposedProduct({left.data(), height, inner, height}, {right.data(), width, inner, width},
                            {target, height, width, stride});
}

}  // namespace

void EliminateLandmarks(const std::vector<LandmarkCoupling>& landmarks, EnvelopeMatrix* A,
                        Eigen::MatrixXd* corner) {
  if (landmarks.empty()) return;
  const BlasOnOneThread guard;
  const std::vector<Eigen::Matrix3d> roots = InverseRoots(landmarks);
  SubtractFromCorner(landmarks, roots, corner);
  const int tiles = A->Tiles(), border = static_cast<int>(corner->rows());
  std::vector<TileRows> of_tiles = LandmarksOfTiles(landmarks, tiles);
  int filled = 0;
  for (int begin = 0; begin < tiles; begin += kTogether) {
    const int end = std::min(tiles, begin + kTogether), reach = A->LastTile(end - 1) + 1;
    ParallelFor(reach - filled, [&](std::size_t i) {
      const int tile = filled + static_cast<int>(i);
      FillRows(landmarks, roots, tile, A->Width(tile), &of_tiles[tile]);
    });
    filled = reach;
    std::vector<std::pair<int, int>> products;  // row of tiles, -1 for the border, and column
    for (int column = begin; column < end; ++column) {
      for (int row = column; row <= A->LastTile(column); ++row) products.emplace_back(row, column);
      products.emplace_back(-1, column);
    }
    ParallelFor(products.size(), [&](std::size_t i) {
      const auto [row, column] = products[i];
      const TileRows& b = of_tiles[column];
      if (row >= 0) {
        SubtractProduct(of_tiles[row], b, A->Tile(row, column), A->Stride(column));
        return;
      }
      Eigen::MatrixXd of_border(border, b.rows.cols());
      for (std::size_t k = 0; k < b.landmarks.size(); ++k) {
        FillBorderRows(landmarks[b.landmarks[k]], roots[b.landmarks[k]], of_border.middleCols<3>(3 * k));
      }
      const int inner = static_cast<int>(of_border.cols()), width = A->Width(column);
      SubtractTransposedProduct({of_border.data(), border, inner, border},
                                {b.rows.data(), width, inner, width},
                                {&A->border(0, column * kTile), border, width, border});
    });
    for (int column = begin; column < end; ++column) of_tiles[column] = {};
  }
}

void EliminateLandmarksFromCorner(const std::vector<LandmarkCoupling>& landmarks, Eigen::MatrixXd* corner) {
  SubtractFromCorner(landmarks, InverseRoots(landmarks), corner);
}

}  // namespace mlic
