#include "mlic_core/association/ring_errors.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

constexpr Eigen::Index kRingsPerKnot = 4;  // from: structural, of what is taken for smooth
// Standard deviations that are compared, each so many times the last. m, rad.
constexpr double kLeastRange = 1e-4;      // from: structural, far below what a ring shows of itself
constexpr double kLeastElevation = 1e-5;  // from: structural, likewise
constexpr double kStep = 1.5;             // from: structural; the likelihood is flat about its maximum
constexpr int kSteps = 17;                // from: structural; up to 4 cm and 4 mrad

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

// Coefficients of the trend, of ranges and then of elevations, whose rings' own errors have been solved for.
class TrendEquations {
 public:
  explicit TrendEquations(Eigen::Index columns)
      : columns_(columns),
        information_(Eigen::MatrixXd::Zero(2 * columns, 2 * columns)),
        gradient_(Eigen::VectorXd::Zero(2 * columns)) {}

  void Add(const Eigen::MatrixXd& trend, Eigen::Index ring, const Eigen::Matrix2d& information,
           const Eigen::Vector2d& gradient) {
    for (int a = 0; a < 2; ++a) {
      gradient_.segment(a * columns_, columns_) += gradient[a] * trend.row(ring).transpose();
      for (int b = 0; b < 2; ++b) {
        information_.block(a * columns_, b * columns_, columns_, columns_) +=
            information(a, b) * trend.row(ring).transpose() * trend.row(ring);
      }
    }
  }

  // What no ring shows stays at zero.
  void Solve() {
    scale_ = information_.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled = scale_.asDiagonal() * information_ * scale_.asDiagonal();
    scaled.diagonal().array() += 1e-9;
    solver_.compute(scaled);
    solution_ = -scale_.cwiseProduct(solver_.solve(scale_.cwiseProduct(gradient_)));
  }
  Eigen::Vector2d At(const Eigen::MatrixXd& trend, Eigen::Index ring) const {
    return {trend.row(ring).dot(solution_.head(columns_)), trend.row(ring).dot(solution_.tail(columns_))};
  }
  // By how much the trend lowers the cost.
  double Gain() const { return -0.5 * gradient_.dot(solution_); }
  double HalfLogDeterminant() const {
    return 0.5 * solver_.vectorD().array().max(1e-300).log().sum() - scale_.array().log().sum();
  }

 private:
  Eigen::Index columns_;
  Eigen::MatrixXd information_;
  Eigen::VectorXd gradient_, scale_, solution_;
  Eigen::LDLT<Eigen::MatrixXd> solver_;
};

// A ring's covariance, given the trend: (H + T^-1)^-1, for variances T that may be zero.
struct RingPosterior {
  Eigen::Matrix2d covariance;
  double half_log_determinant;  // of I + T H

  RingPosterior(const Eigen::Matrix2d& information, const Eigen::Vector2d& variances) {
    const Eigen::Vector2d root = variances.cwiseSqrt();
    const Eigen::Matrix2d whole =
        Eigen::Matrix2d::Identity() + Eigen::Matrix2d(root.asDiagonal() * information * root.asDiagonal());
    covariance = root.asDiagonal() * whole.inverse() * root.asDiagonal();
    half_log_determinant = 0.5 * std::log(whole.determinant());
  }
};

struct Solution {
  TrendEquations trend;
  double minus_log_likelihood;  // restricted, but for a constant
};

Solution SolveTrend(const std::vector<RingEquations>& rings, const Eigen::MatrixXd& basis,
                    const Eigen::Vector2d& variances) {
  Solution solution{TrendEquations(basis.cols()), 0.0};
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Eigen::Matrix2d& H = rings[i].information;
    const Eigen::Vector2d& g = rings[i].gradient;
    const RingPosterior ring(H, variances);
    solution.trend.Add(basis, static_cast<Eigen::Index>(i), H - H * ring.covariance * H,
                       g - H * (ring.covariance * g));
    solution.minus_log_likelihood += ring.half_log_determinant - 0.5 * g.dot(ring.covariance * g);
  }
  solution.trend.Solve();
  solution.minus_log_likelihood += solution.trend.HalfLogDeterminant() - solution.trend.Gain();
  return solution;
}

}  // namespace

RingVariances MeasureRingVariances(const std::vector<RingEquations>& rings, bool in_elevation) {
  const Eigen::MatrixXd basis = SmoothBasis(static_cast<Eigen::Index>(rings.size()));
  const auto deviation = [](double least, int step) {
    return step == 0 ? 0.0 : least * std::pow(kStep, step - 1);
  };
  RingVariances best;
  const double none = SolveTrend(rings, basis, Eigen::Vector2d::Zero()).minus_log_likelihood;
  for (int r = 0; r <= kSteps; ++r) {
    for (int e = 0; e <= (in_elevation ? kSteps : 0); ++e) {
      const Eigen::Vector2d deviations(deviation(kLeastRange, r), deviation(kLeastElevation, e));
      const Eigen::Vector2d variances = deviations.cwiseAbs2();
      const double evidence = none - SolveTrend(rings, basis, variances).minus_log_likelihood;
      if (evidence > best.evidence) best = {variances, evidence};
    }
  }
  return best;
}

Eigen::MatrixX2d PredictRingErrors(const std::vector<RingEquations>& rings, const Eigen::MatrixXd& trend,
                                   const Eigen::Vector2d& variances) {
  const Solution solution = SolveTrend(rings, trend, variances);
  Eigen::MatrixX2d errors(trend.rows(), 2);
  for (Eigen::Index i = 0; i < trend.rows(); ++i) {
    const RingEquations& ring = rings[static_cast<std::size_t>(i)];
    errors.row(i) = -(RingPosterior(ring.information, variances).covariance *
                      (ring.gradient + ring.information * solution.trend.At(trend, i)))
                         .transpose();
  }
  return errors;
}

double GainOfCorrections(const std::vector<RingEquations>& rings, const Eigen::MatrixXd& trend,
                         const Eigen::MatrixX2d& errors) {
  std::vector<RingEquations> corrected = rings;
  double gain = 0.0;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Eigen::Vector2d error = errors.row(static_cast<Eigen::Index>(i));
    gain -= error.dot(rings[i].gradient + 0.5 * rings[i].information * error);
    corrected[i].gradient += rings[i].information * error;
  }
  return gain + SolveTrend(corrected, trend, Eigen::Vector2d::Zero()).trend.Gain() -
         SolveTrend(rings, trend, Eigen::Vector2d::Zero()).trend.Gain();
}

double ScatterOfParts(const std::vector<std::vector<RingEquations>>& parts, const Eigen::MatrixXd& trend,
                      const Eigen::MatrixX2d& errors) {
  constexpr double kRank = 1e-9;  // from: guard, rounding
  double squares = 0.0;
  Eigen::Index freedom = 2 * trend.cols() - errors.size();
  for (const std::vector<RingEquations>& part : parts) {
    const double by_trend = SolveTrend(part, trend, Eigen::Vector2d::Zero()).trend.Gain();
    squares -= 2.0 * (GainOfCorrections(part, trend, errors) + by_trend);
    freedom -= 2 * trend.cols();
    for (const RingEquations& ring : part) {
      // What the ring's own best errors would lower them by: along eigenvectors, as one may not be shown.
      const Eigen::Vector2d scale = ring.information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
      const SymmetricEigen<Eigen::Dynamic> eigen(scale.asDiagonal() * ring.information * scale.asDiagonal());
      const Eigen::Vector2d along = eigen.eigenvectors().transpose() * scale.cwiseProduct(ring.gradient);
      for (int k = 0; k < 2; ++k) {
        if (eigen.eigenvalues()[k] < kRank) continue;
        squares += along[k] * along[k] / eigen.eigenvalues()[k];
        ++freedom;
      }
    }
  }
  return freedom > 0 ? squares / static_cast<double>(freedom) : 1.0;
}

}  // namespace mlic
