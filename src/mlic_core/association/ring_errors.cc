#include "mlic_core/association/ring_errors.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/sizes_of_draws.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

constexpr Eigen::Index kRingsPerKnot = 4;  // from: structural, of what is taken for smooth
constexpr double kRank = 1e-9;             // from: guard, rounding
// Standard deviations that are compared, each so many times the last. m, rad.
constexpr double kLeastRange = 1e-4;      // from: structural, far below what a ring shows of itself
constexpr double kLeastElevation = 1e-5;  // from: structural, likewise
constexpr double kStep = 1.5;             // from: structural; the likelihood is flat about its maximum
constexpr double kRangeOfSizes = 400.0;   // from: structural; up to 4 cm and 4 mrad

// Hat functions over the rings, one row for each ring.
Eigen::MatrixXd SmoothBasis(Eigen::Index rings) {
  const Eigen::Index knots = (rings - 1) / kRingsPerKnot + 2;
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(rings, knots);
  for (Eigen::Index i = 0; i < rings; ++i) {
    const double at =
        static_cast<double>(i * (knots - 1)) / static_cast<double>(std::max<Eigen::Index>(1, rings - 1));
    const Eigen::Index left = std::min(static_cast<Eigen::Index>(at), knots - 2);
    basis(i, left + 1) = at - static_cast<double>(left);
    basis(i, left) = 1.0 - basis(i, left + 1);
  }
  return basis;
}

// What rings err by given their equations H, g, for variances T that may be zero; of ranges alone where
// elevations do not err.
class Posterior {
 public:
  Posterior(const RingEquations& rings, const Eigen::Vector2d& variances) {
    const Eigen::Index n = variances[1] > 0.0 ? 2 * rings.Rings() : rings.Rings();
    root_ = Eigen::VectorXd::Constant(n, std::sqrt(variances[0]));
    root_.tail(n - rings.Rings()).setConstant(std::sqrt(variances[1]));
    Eigen::MatrixXd whole = root_.asDiagonal() * rings.information.topLeftCorner(n, n) * root_.asDiagonal();
    whole.diagonal().array() += 1.0;
    solver_.compute(whole);
  }

  Eigen::VectorXd Errors(const Eigen::VectorXd& gradient) const {
    return -root_.cwiseProduct(solver_.solve(root_.cwiseProduct(gradient.head(root_.size()))));
  }
  // (H + T^-1)^-1
  Eigen::MatrixXd Covariance() const {
    const Eigen::MatrixXd solved = solver_.solve(Eigen::MatrixXd(root_.asDiagonal()));
    return root_.asDiagonal() * solved;
  }
  // Of I + T H.
  double HalfLogDeterminant() const { return solver_.matrixLLT().diagonal().array().log().sum(); }

 private:
  Eigen::VectorXd root_;
  Eigen::LLT<Eigen::MatrixXd> solver_;
};

// The logarithm of the likelihood's ratio to no errors. without_trend: what is smooth.
double Evidence(const RingEquations& without_trend, const Eigen::Vector2d& variances) {
  const Posterior posterior(without_trend, variances);
  const Eigen::VectorXd errors = posterior.Errors(without_trend.gradient);
  return -0.5 * errors.dot(without_trend.gradient.head(errors.size())) - posterior.HalfLogDeterminant();
}

Eigen::VectorXd Stacked(const Eigen::MatrixX2d& errors) {
  Eigen::VectorXd stacked(errors.size());
  stacked << errors.col(0), errors.col(1);
  return stacked;
}

// Standard deviations from none on.
std::vector<double> Deviations(double least) {
  std::vector<double> deviations = SizesBetween(least, kRangeOfSizes * least, kStep);
  deviations.insert(deviations.begin(), 0.0);
  return deviations;
}

// For MeanSquareOfSizes; sizes: of the errors of ranges.
struct DrawsOfRings {
  RingEquations rings, smooth_solved;
  double elevation_variance;
  Eigen::VectorXd corrected;

  Eigen::Vector2d Variances(double size) const { return {size * size, elevation_variance}; }
  double Gain(double size) const { return 2.0 * Evidence(smooth_solved, Variances(size)); }
  Eigen::MatrixXd MeanSquare(double size) const {
    const RingPrediction prediction = PredictRingErrors(rings, Variances(size));
    const Eigen::VectorXd beyond = Stacked(prediction.errors) - corrected;
    return prediction.covariance + beyond * beyond.transpose();
  }
};

}  // namespace

RingEquations WithoutTrend(const RingEquations& rings, const Eigen::MatrixXd& trend) {
  const Eigen::Index n = rings.Rings(), columns = trend.cols();
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(2 * n, 2 * columns);
  both.topLeftCorner(n, columns) = trend;
  both.bottomRightCorner(n, columns) = trend;
  const Eigen::MatrixXd coupling = rings.information * both;
  Eigen::MatrixXd of_trend = both.transpose() * coupling;
  // Elevations and ranges have other units. What no ring shows stays.
  const Eigen::VectorXd scale = of_trend.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const SymmetricEigen<Eigen::Dynamic> eigen(scale.asDiagonal() * of_trend * scale.asDiagonal());
  const Eigen::VectorXd inverse =
      eigen.eigenvalues().unaryExpr([](double value) { return value > kRank ? 1.0 / value : 0.0; });
  const Eigen::MatrixXd root = scale.asDiagonal() * eigen.eigenvectors() * inverse.cwiseSqrt().asDiagonal();
  const Eigen::MatrixXd shown = coupling * root;
  const Eigen::VectorXd along = root.transpose() * (both.transpose() * rings.gradient);
  return {rings.information - shown * shown.transpose(), rings.gradient - shown * along};
}

RingVariances MeasureRingVariances(const RingEquations& rings, bool in_elevation) {
  const RingEquations rough = WithoutTrend(rings, SmoothBasis(rings.Rings()));
  RingVariances best;
  // The best of one kind for what is best of the other, from none on, until neither moves.
  for (bool improved = true; improved;) {
    improved = false;
    for (int kind = 0; kind < (in_elevation ? 2 : 1); ++kind) {
      for (const double deviation : Deviations(kind == 0 ? kLeastRange : kLeastElevation)) {
        Eigen::Vector2d variances = best.variances;
        variances[kind] = deviation * deviation;
        const double evidence = Evidence(rough, variances);
        if (evidence <= best.evidence) continue;
        best = {variances, evidence};
        improved = in_elevation;
      }
    }
  }
  return best;
}

RingPrediction PredictRingErrors(const RingEquations& without_trend, const Eigen::Vector2d& variances) {
  const Posterior posterior(without_trend, variances);
  const Eigen::Index rings = without_trend.Rings();
  RingPrediction prediction{Eigen::MatrixX2d::Zero(rings, 2), Eigen::MatrixXd::Zero(2 * rings, 2 * rings)};
  const Eigen::VectorXd errors = posterior.Errors(without_trend.gradient);
  const Eigen::Index n = errors.size();
  prediction.errors.col(0) = errors.head(rings);
  prediction.errors.col(1).head(n - rings) = errors.tail(n - rings);
  prediction.covariance.topLeftCorner(n, n) = posterior.Covariance();
  return prediction;
}

Eigen::MatrixXd MeanSquareBeyond(const RingEquations& rings, const Eigen::MatrixXd& trend,
                                 double elevation_variance, const Eigen::MatrixX2d& corrected) {
  const Eigen::MatrixX2d trendless = corrected - trend * (trend.transpose() * corrected);
  const DrawsOfRings draws{WithoutTrend(rings, trend), WithoutTrend(rings, SmoothBasis(rings.Rings())),
                           elevation_variance, Stacked(trendless)};
  return MeanSquareOfSizes(draws, SizesBetween(kLeastRange, kRangeOfSizes * kLeastRange, kStep));
}

double GainOfCorrections(const RingEquations& without_trend, const Eigen::MatrixX2d& errors) {
  const Eigen::VectorXd by = Stacked(errors);
  return -by.dot(without_trend.gradient + 0.5 * without_trend.information * by);
}

double ScatterOfParts(const std::vector<RingEquations>& parts, Eigen::Index trend_columns,
                      const Eigen::MatrixX2d& errors) {
  double squares = 0.0;
  Eigen::Index freedom = 2 * trend_columns - errors.size();
  for (const RingEquations& part : parts) {
    squares -= 2.0 * GainOfCorrections(part, errors);
    // What the part's own best errors would lower them by: along eigenvectors, as some may not be shown.
    const Eigen::VectorXd scale = part.information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const SymmetricEigen<Eigen::Dynamic> eigen(scale.asDiagonal() * part.information * scale.asDiagonal());
    const Eigen::VectorXd along = eigen.eigenvectors().transpose() * scale.cwiseProduct(part.gradient);
    for (Eigen::Index k = 0; k < along.size(); ++k) {
      if (eigen.eigenvalues()[k] < kRank) continue;
      squares += along[k] * along[k] / eigen.eigenvalues()[k];
      ++freedom;
    }
  }
  return freedom > 0 ? squares / static_cast<double>(freedom) : 1.0;
}

}  // namespace mlic
