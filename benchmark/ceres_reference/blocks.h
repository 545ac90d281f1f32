#pragma once

#include <algorithm>
#include <vector>

#include "ceres_reference/evaluation_point.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic::ceres_reference {

// The parameter blocks of one residual, in order.
struct BlockList {
  void Add(double* block, int ambient) {
    pointers.push_back(block);
    ambients.push_back(ambient);
  }
  std::vector<double*> pointers;
  std::vector<int> ambients;
};

// Writes rows [row, row + tangent) of a factor's Jacobian (one column for each residual) to Ceres's block
// (row by row, residuals x ambient), zeros to its further columns. block null: the parameters are constant.
template <typename Jacobian>
void WriteBlock(const Jacobian& J, int row, int tangent, int ambient, double* block) {
  if (block == nullptr) return;
  for (int k = 0; k < J.cols(); ++k) {
    for (int i = 0; i < ambient; ++i) *block++ = i < tangent ? J(row + i, k) : 0.0;
  }
}

inline void ClearBlocks(int residuals, const std::vector<int>& ambients, double** jacobians) {
  for (std::size_t b = 0; b < ambients.size(); ++b) {
    if (jacobians[b] != nullptr) std::fill_n(jacobians[b], residuals * ambients[b], 0.0);
  }
}

// The control points of one spline that a measurement touches whose time lies within [begin, end]. Beyond it
// the polynomial of the nearest segment goes on.
struct KnotWindow {
  KnotWindow(const UniformKnots& knots, double begin, double end)
      : first(SplineBasis(knots, begin).first), count(SplineBasis(knots, end).first - first + 4) {}

  SplineBasis Basis(const UniformKnots& knots, double time) const {
    SplineBasis basis({knots.start + first * knots.spacing, knots.spacing, count}, time);
    basis.first += first;
    return basis;
  }

  // Writes the four control points' rows from `row` on to those of the window's blocks that `basis` uses. J's
  // first column is the residual `from` of the blocks.
  template <typename Jacobian>
  void Write(const Jacobian& J, int row, const SplineBasis& basis, int ambient, double** blocks,
             int from = 0) const {
    for (int j = 0; j < count; ++j) {
      if (blocks[j] == nullptr) continue;
      double* const block = blocks[j] + from * ambient;
      const int used = first + j - basis.first;
      if (used >= 0 && used < 4) {
        WriteBlock(J, row + 3 * used, 3, ambient, block);
      } else {
        std::fill_n(block, J.cols() * ambient, 0.0);
      }
    }
  }

  int first, count;
};

// Both splines' control points of a measurement. A clock's offset may move by kClockMargin while the blocks
// of a residual stay what they are; starts that are worth an association are nearer.
struct MeasurementKnots {
  static constexpr double kClockMargin = 2e-3;  // s

  MeasurementKnots(const SplitSpline& trajectory, double time, double margin)
      : rotation(trajectory.rotation.knots(), time - margin, time + margin),
        position(trajectory.position.knots(), time - margin, time + margin) {}

  void AddTo(EvaluationPoint::DriveBlocks* drive, BlockList* blocks) const {
    for (int j = 0; j < rotation.count; ++j) blocks->Add(drive->rotations[rotation.first + j].data(), 4);
    for (int j = 0; j < position.count; ++j) blocks->Add(drive->positions[position.first + j].data(), 3);
  }
  int Count() const { return rotation.count + position.count; }

  // All factors begin with 12 rows of rotation and 12 of position.
  template <typename Jacobian>
  void Write(const Jacobian& J, const SplineBasis& rotation_basis, const SplineBasis& position_basis,
             double** blocks) const {
    rotation.Write(J, 0, rotation_basis, 4, blocks);
    position.Write(J, 12, position_basis, 3, blocks + rotation.count);
  }

  KnotWindow rotation, position;
};

}  // namespace mlic::ceres_reference
