#include "mlic_core/initialization/knot_spacing.h"

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/random.h"
#include "mlic_core/imu/low_pass.h"
#include "mlic_core/imu/noise_spectrum.h"

namespace mlic {
namespace {

// from: measured, trials, open 2: 3.5 sigmas off with 0.01 of the noise of samples, 1.9 with less.
constexpr double kTolerance = 0.01;            // of the variance of the noise that the finest knots carry
constexpr int kReferenceSamples = 16384;       // from: guard, its own scatter is below that of a drive's
constexpr double kHannVariance = 35.0 / 18.0;  // from: derivation, sum w^4 N / (sum w^2)^2 of the window
constexpr double kMedianVariance = 2.08;  // from: derivation, 1 / ln(2)^2, of exponential variates' median

// Times from zero (s) and values, one axis in each column.
struct Signal {
  std::vector<double> times;
  Eigen::MatrixXd values;

  double Rate() const { return (times.size() - 1.0) / times.back(); }
};

// Residuals of a least-squares fit by a uniform B-spline of the given degree (1 or 2).
Eigen::MatrixXd FitResiduals(const Signal& signal, double spacing, int degree) {
  const std::size_t samples = signal.times.size();
  const int segments = std::max(1, static_cast<int>(std::ceil(signal.times.back() / spacing)));
  const int count = segments + degree;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 3);
  std::vector<Eigen::Vector4d> weights(samples);
  std::vector<int> first(samples);
  Eigen::MatrixXd band = Eigen::MatrixXd::Zero(3, count);
  for (std::size_t k = 0; k < samples; ++k) {
    const double at = signal.times[k] / spacing;
    first[k] = std::min(segments - 1, static_cast<int>(at));
    const double u = at - first[k];
    weights[k] = degree == 1
                     ? Eigen::Vector4d(1.0 - u, u, 0.0, 0.0)
                     : Eigen::Vector4d(0.5 * (1.0 - u) * (1.0 - u), 0.5 + u - u * u, 0.5 * u * u, 0.0);
    for (int i = 0; i <= degree; ++i) {
      right.row(first[k] + i) += weights[k][i] * signal.values.row(k);
      for (int j = 0; j <= i; ++j) band(i - j, first[k] + j) += weights[k][i] * weights[k][j];
    }
  }
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < 3 && j + i < count; ++i) {
      entries.emplace_back(j + i, j, band(i, j) + (i == 0 ? 1e-9 : 0.0));
    }
  }
  Eigen::SparseMatrix<double> normal(count, count);
  normal.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(normal);
  const Eigen::MatrixXd fit = solver.solve(right);
  Eigen::MatrixXd residuals = signal.values;
  for (std::size_t k = 0; k < samples; ++k) {
    for (int i = 0; i <= degree; ++i) residuals.row(k) -= weights[k][i] * fit.row(first[k] + i);
  }
  return residuals;
}

// Splines would alias what is above their band into it.
Signal LowPassed(const Signal& signal, double top) {
  const double rate = signal.Rate();
  if (3.0 * top > 0.5 * rate) return signal;
  const LowPass filter(top);
  const int half = static_cast<int>(filter.HalfWidth() * rate);
  std::vector<double> weights(half + 1);
  for (int i = 0; i <= half; ++i) weights[i] = filter.Weight(i / rate);
  Signal result = signal;
  const int count = static_cast<int>(signal.times.size());
  for (int k = 0; k < count; ++k) {
    // As wide to either side as the ends leave room for: steady slopes stay as they are.
    const int reach = std::min({half, k, count - 1 - k});
    double total = 0.0;
    result.values.row(k).setZero();
    for (int i = -reach; i <= reach; ++i) {
      result.values.row(k) += weights[std::abs(i)] * signal.values.row(k + i);
      total += weights[std::abs(i)];
    }
    result.values.row(k) /= total;
  }
  return result;
}

// What is left of a signal below `top` (Hz), summed over the axes.
double VarianceBelow(double top, const Eigen::MatrixXd& residuals, double rate) {
  double sum = 0.0;
  for (int a = 0; a < 3; ++a) sum += NoiseSpectrum(residuals.col(a), rate).Variance(0.0, top);
  return sum;
}

// White noise of variance one at the rate.
Signal ReferenceNoise(double rate) {
  Random random(1);
  Signal noise;
  noise.values.resize(kReferenceSamples, 3);
  for (int k = 0; k < kReferenceSamples; ++k) {
    noise.times.push_back(k / rate);
    for (int a = 0; a < 3; ++a) noise.values(k, a) = random.Normal();
  }
  return noise;
}

double Choose(const Signal& measured, double finest, double lidar_period, int degree) {
  constexpr double kStep = 1.25;     // from: structural, steps of the search
  constexpr double kCoarsest = 0.2;  // from: guard, finer knots than needed cost time only
  const double rate = measured.Rate(), top = 0.5 / finest, duration = measured.times.back();
  const Signal signal = LowPassed(measured, top);
  const Eigen::MatrixXd left = FitResiduals(signal, finest, degree);
  double white = 0.0;  // of the axes together
  for (int a = 0; a < 3; ++a) white += NoiseSpectrum(left.col(a), rate).WhiteVariance(top, 2.0 * top);
  const Signal noise = LowPassed(ReferenceNoise(rate), top);
  const double least = VarianceBelow(top, left, rate);
  const double least_of_noise = VarianceBelow(top, FitResiduals(noise, finest, degree), rate) / 3.0;
  const double tolerated = kTolerance * white * std::min(1.0, 2.0 * top / rate);
  double chosen = finest;
  for (double spacing = finest * kStep; spacing <= std::max(kCoarsest, finest); spacing *= kStep) {
    const double lost = VarianceBelow(top, FitResiduals(signal, spacing, degree), rate) - least;
    const double of_noise =
        white * (VarianceBelow(top, FitResiduals(noise, spacing, degree), rate) / 3.0 - least_of_noise);
    const double freed = duration / finest - duration / spacing;  // control points
    const double scatter =
        std::sqrt(kHannVariance * (2.0 / (3.0 * freed) + kMedianVariance / (1.5 * duration / finest)));
    if (lost <= (1.0 + scatter) * of_noise + tolerated) chosen = spacing;
  }
  return chosen > finest ? chosen : std::min(chosen, std::max(kFinestKnots, lidar_period));
}

}  // namespace

KnotSpacing ChooseKnotSpacing(const std::vector<ImuSample>& imu, double lidar_period) {
  Signal rates, forces;
  rates.values.resize(imu.size(), 3);
  forces.values.resize(imu.size(), 3);
  for (std::size_t k = 0; k < imu.size(); ++k) {
    rates.times.push_back(imu[k].time - imu.front().time);
    rates.values.row(k) = imu[k].angular_velocity.transpose();
    forces.values.row(k) = imu[k].specific_force.transpose();
  }
  forces.times = rates.times;
  const double finest = std::max(kFinestKnots, 2.0 * MedianPeriod(imu));
  return {Choose(rates, finest, lidar_period, 2), Choose(forces, finest, lidar_period, 1)};
}

}  // namespace mlic
