#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/solver/accumulator.h"

namespace mlic {

// What the terms of the joint problem are linearised at, and where their rows go.
struct LinearizationPoint {
  const JointProblem& problem;
  const CalibrationState& state;
  const Layout& layout;
};

// Parts of parallel sums; fixed, so that the sums do not depend on the threads.
constexpr std::size_t kLinearizationChunks = 16;  // from: structural

// Huber's loss beyond two sigmas: the cost of a residual of this size, and the weight of its square.
inline double RobustCost(double whitened, double* weight) {
  constexpr double kHuber = 2.0;  // from: derivation, Huber's loss keeps 99 % of efficiency
  const double size = std::abs(whitened);
  if (size <= kHuber) {
    *weight = 1.0;
    return whitened * whitened;
  }
  *weight = kHuber / size;
  return kHuber * (2.0 * size - kHuber);
}

// Starts of the 8 control points' columns: 4 of rotation, 4 of position.
struct KnotColumns {
  KnotColumns(const Layout& layout, std::size_t drive, int rotation_first, int position_first) {
    for (int j = 0; j < 4; ++j) {
      start[j] = layout.drives[drive].rotation[rotation_first + j];
      start[4 + j] = layout.drives[drive].position[position_first + j];
    }
  }
  int operator[](int j) const { return start[j]; }
  int start[8];
};

// Adds weighted rows J (one column for each residual; its rows are the 24 scalars of the control points, then
// the calibration at the given indices) with weighted residuals.
template <typename Rows, typename Residual>
void AddRows(const KnotColumns& columns, const std::vector<int>& calibration, const Rows& J,
             const Residual& r, Accumulator* sum) {
  const Eigen::MatrixXd H = J * J.transpose();
  const Eigen::VectorXd g = J * r;
  for (int a = 0; a < 8; ++a) {
    sum->gradient_knots.template segment<3>(sum->Local(columns[a])) += g.segment<3>(3 * a);
    for (int b = 0; b < 8; ++b) {
      if (columns[a] >= columns[b]) sum->AddBand(columns[a], columns[b], H.block<3, 3>(3 * a, 3 * b));
    }
    for (std::size_t i = 0; i < calibration.size(); ++i) {
      sum->border.template block<1, 3>(calibration[i], sum->Local(columns[a])) +=
          H.block<1, 3>(24 + i, 3 * a);
    }
  }
  for (std::size_t i = 0; i < calibration.size(); ++i) {
    sum->gradient_calibration[calibration[i]] += g[24 + i];
    for (std::size_t k = 0; k < calibration.size(); ++k) {
      sum->corner(calibration[i], calibration[k]) += H(24 + i, 24 + k);
    }
  }
}

// Where to cut landmarks into kLinearizationChunks parts with equal numbers of observations; one more than
// parts. begin: of each landmark's observations, one more than landmarks.
inline std::vector<std::size_t> CutByObservations(const std::vector<std::size_t>& begin) {
  const std::size_t count = begin.size() - 1;
  std::vector<std::size_t> cut(kLinearizationChunks + 1, count);
  for (std::size_t c = 0; c < kLinearizationChunks; ++c) {
    const std::size_t observation = begin[count] * c / kLinearizationChunks;
    cut[c] = std::lower_bound(begin.begin(), begin.end() - 1, observation) - begin.begin();
  }
  return cut;
}

// The couplings of one landmark to control points while its observations are summed.
class CouplingSlots {
 public:
  explicit CouplingSlots(int knots) : slot_(knots / 3, -1) {}
  Eigen::Matrix3d& Block(int column) {
    int& slot = slot_[column / 3];
    if (slot < 0) {
      slot = static_cast<int>(columns_.size());
      columns_.push_back(column);
      blocks_.push_back(Eigen::Matrix3d::Zero());
    }
    return blocks_[slot];
  }
  // Gives the landmark its couplings, no more memory than they need, and begins the next.
  void Finish(LandmarkCoupling* landmark) {
    landmark->columns.assign(columns_.begin(), columns_.end());
    landmark->blocks.assign(blocks_.begin(), blocks_.end());
    for (const int column : columns_) slot_[column / 3] = -1;
    columns_.clear();
    blocks_.clear();
  }

 private:
  std::vector<int> slot_;
  std::vector<int> columns_;
  std::vector<Eigen::Matrix3d> blocks_;
};

}  // namespace mlic
