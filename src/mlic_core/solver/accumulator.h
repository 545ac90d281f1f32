#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// Normal equations H x = -g of the joint problem with the structure that the problem has: control points
// banded in time, bordered by the calibration, with 3-parameter landmarks (planes, points) that are
// eliminated first. Eliminating a landmark couples all control points that saw it. As long as no landmark is
// seen over more than a part of a drive, columns end early (EnvelopeMatrix), and time and memory grow with
// the drive's length, not with its cube and square. docs/method.md, section 6.
struct Accumulator {
  // Sums over the control points' columns from first_knot on, `knots` of them (scalars).
  Accumulator(int knots, int bandwidth, int calibration, int first_knot = 0);

  // Where a control point's column stands here.
  int Local(int column) const { return column - first_knot; }

  // H[i, j] += block for control-point columns i >= j (both starts of 3) or i == j; lower triangle of the
  // band.
  void AddBand(int i, int j, const Eigen::Matrix3d& block) {
    for (int c = 0; c < 3; ++c) {
      const int above = i == j ? c : 0;  // rows of the block that lie above the diagonal
      double* to = &band(i - j + above - c, Local(j) + c);
      for (int r = above; r < 3; ++r) to[r - above] += block(r, c);
    }
  }
  // other: over a part of these columns.
  Accumulator& operator+=(const Accumulator& other);

  int first_knot;
  Eigen::MatrixXd band;    // (bandwidth + 1) x knots: band(k, j) = H(j + k, j), j counted from first_knot
  Eigen::MatrixXd border;  // calibration x knots
  Eigen::MatrixXd corner;  // calibration x calibration, full
  Eigen::VectorXd gradient_knots;
  Eigen::VectorXd gradient_calibration;
  double cost = 0.0;  // sum of robust squared whitened residuals
};

// What one landmark adds: its own block, and its couplings to control points and calibration.
struct LandmarkCoupling {
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  std::vector<int> columns;                              // starts of 3, in the vector of control points
  std::vector<Eigen::Matrix3d> blocks;                   // control point (rows) x landmark (columns)
  Eigen::Matrix<double, Eigen::Dynamic, 3> calibration;  // calibration x landmark
};

}  // namespace mlic
