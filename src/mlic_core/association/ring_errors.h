#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// What the points of a LiDAR say of its rings' ranges (m) and elevations (rad): normal equations about no
// error, residuals whitened. Ranges of all rings, then elevations; rings sorted by elevation.
struct RingEquations {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;

  static RingEquations Zero(Eigen::Index rings) {
    return {Eigen::MatrixXd::Zero(2 * rings, 2 * rings), Eigen::VectorXd::Zero(2 * rings)};
  }
  Eigen::Index Rings() const { return gradient.size() / 2; }
};

// How widely rings err: variances of range (m^2) and elevation (rad^2).
struct RingVariances {
  Eigen::Vector2d variances = Eigen::Vector2d::Zero();
  double evidence = 0.0;  // by how much they raise the logarithm of the likelihood over none
};

// Of rings that err each for itself, by restricted maximum likelihood (Patterson and Thompson, 1971): what
// changes smoothly from ring to ring is left out, as it comes from what they see (wide beams on the ground
// err with the incidence). in_elevation: whether they may err in it.
RingVariances MeasureRingVariances(const RingEquations& rings, bool in_elevation);

// What is along `trend` (a row for each ring, for ranges and elevations alike) solved for.
RingEquations WithoutTrend(const RingEquations& rings, const Eigen::MatrixXd& trend);

// What rings err by that err as widely as `variances` says: the best linear unbiased prediction (Henderson,
// 1975), one row (m, rad) for each, and its covariance (ranges, then elevations). What is along the trend is
// not shown: it is zero in the prediction, and has its own variance in the covariance.
struct RingPrediction {
  Eigen::MatrixX2d errors;
  Eigen::MatrixXd covariance;
};
RingPrediction PredictRingErrors(const RingEquations& without_trend, const Eigen::Vector2d& variances);

// The mean of the products of what rings err by beyond `corrected`, over all sizes of the errors of ranges by
// their likelihood (sizes_of_draws.h), those of elevations as given.
Eigen::MatrixXd MeanSquareBeyond(const RingEquations& rings, const Eigen::MatrixXd& trend,
                                 double elevation_variance, const Eigen::MatrixX2d& corrected);

// By how much half the sum of squares falls when the rings are corrected by `errors`.
double GainOfCorrections(const RingEquations& without_trend, const Eigen::MatrixX2d& errors);

// How parts of the points (of the drive, of the view) differ in what they show of the rings, these corrected
// by `errors`: the mean square of the residuals, 1 where the parts differ by their noise alone. parts: each
// without its trend, which takes `trend_columns` from each kind.
double ScatterOfParts(const std::vector<RingEquations>& parts, Eigen::Index trend_columns,
                      const Eigen::MatrixX2d& errors);

}  // namespace mlic
