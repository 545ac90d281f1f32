#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// What the points of one ring say of its range (m) and elevation (rad): normal equations about no error,
// residuals whitened. Neither may be known alone: a ring that meets nothing but ground shows their sum.
struct RingEquations {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
};

// How widely rings err: variances of range (m^2) and elevation (rad^2).
struct RingVariances {
  Eigen::Vector2d variances = Eigen::Vector2d::Zero();
  double evidence = 0.0;  // by how much they raise the logarithm of the likelihood over none
};

// Of rings that err each for itself, by restricted maximum likelihood (Patterson and Thompson, 1971): what
// changes smoothly from ring to ring is left out, as it comes from what they see (wide beams on the ground
// err with the incidence). Rings are sorted by elevation. in_elevation: whether they may err in it.
RingVariances MeasureRingVariances(const std::vector<RingEquations>& rings, bool in_elevation);

// What the rings err by, one row (m, rad) for each: the best linear unbiased prediction (Henderson, 1975).
// What is along `trend` (columns over the rings, for ranges and elevations alike) is free and not part of it:
// the prediction is orthogonal to it.
Eigen::MatrixX2d PredictRingErrors(const std::vector<RingEquations>& rings, const Eigen::MatrixXd& trend,
                                   const Eigen::Vector2d& variances);

// By how much half the sum of squares falls when the rings are corrected by `errors`, the trend at its best
// before and after.
double GainOfCorrections(const std::vector<RingEquations>& rings, const Eigen::MatrixXd& trend,
                         const Eigen::MatrixX2d& errors);

// How parts of the points (of the drive, of the view) differ in what they show of the rings, each part's
// trend at its best and the rings corrected by `errors`: the mean square of the residuals, 1 where the parts
// differ by their noise alone.
double ScatterOfParts(const std::vector<std::vector<RingEquations>>& parts, const Eigen::MatrixXd& trend,
                      const Eigen::MatrixX2d& errors);

}  // namespace mlic
