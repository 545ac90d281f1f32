#include "mlic_core/uncertainty/imu_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/imu/noise_spectrum.h"

namespace mlic {
namespace {

constexpr std::size_t kFewest = 35;                     // samples; from: guard
constexpr double kChance = 3.0;                         // standard deviations; from: derivation, 1 in 700
constexpr std::array<double, 4> kLengths{1, 2, 5, 10};  // s; from: definition

double RobustSigma(const Eigen::VectorXd& values) {
  std::vector<double> sizes;
  for (const double value : values) sizes.push_back(std::abs(value));
  return 1.4826 * Median(std::move(sizes));
}

double RateOf(const ImuResiduals& residuals) {
  return (static_cast<double>(residuals.times.size()) - 1.0) /
         std::max(1e-9, residuals.times.back() - residuals.times.front());
}

// A mean of so many squares of standard normal variates is beyond it by chance once in 700 (Wilson and
// Hilferty, 1931).
double LargestByChance(double freedom) {
  const double spread = 2.0 / (9.0 * freedom);
  return std::pow(1.0 - spread + kChance * std::sqrt(spread), 3);
}

// Sigmas of three components that follow each other, from `first`.
Eigen::Vector3d SigmaOf(const ImuResiduals& residuals, int first, double knot_spacing) {
  const double rate = RateOf(residuals), top = TopOfBand(rate, knot_spacing);
  const auto count = static_cast<Eigen::Index>(residuals.values.size());
  Eigen::Vector3d sigma;
  double colour =
      0.0;  // mean over the axes of the density by that of white noise with the residuals' scatter
  for (int a = 0; a < 3; ++a) {
    Eigen::VectorXd values(count);
    for (Eigen::Index k = 0; k < count; ++k) values[k] = residuals.values[k][first + a];
    sigma[a] = std::max(1e-12, RobustSigma(values));
    colour += NoiseSpectrum(values, rate).WhiteVariance(top, 2.0 * top) / (3.0 * sigma[a] * sigma[a]);
  }
  // Of a median of exponential variates (1 / ln(2)^2), with neighbours that a Hann window ties (35 / 18).
  const double bins = 3.0 * std::max(1.0, top * static_cast<double>(count) / rate);
  const double scatter = std::sqrt(35.0 / 18.0 / (std::log(2.0) * std::log(2.0)) / bins);
  if (colour > 1.0 + kChance * scatter) sigma *= std::sqrt(colour);
  return sigma;
}

}  // namespace

ImuSigma MeasureImuSigma(const ImuResiduals& residuals, const SplitSpline& trajectory,
                         const ImuSigma& given) {
  if (residuals.values.size() < kFewest) return given;
  ImuSigma sigma;
  sigma.gyroscope = given.gyroscope.cwiseMax(SigmaOf(residuals, 0, trajectory.rotation.knots().spacing));
  sigma.accelerometer =
      given.accelerometer.cwiseMax(SigmaOf(residuals, 3, trajectory.position.knots().spacing));
  return sigma;
}

ImuMeanExcess MeasureMeanExcess(const ImuResiduals& residuals, const ImuSigma& sigma) {
  ImuMeanExcess excess;
  if (residuals.times.empty()) return excess;
  Eigen::Matrix<double, 6, 1> of_one;
  of_one << sigma.gyroscope, sigma.accelerometer;
  const double start = residuals.times.front(), duration = residuals.times.back() - start;
  for (const double length : kLengths) {
    const auto stretches = static_cast<std::size_t>(duration / length);
    if (stretches < 2) break;
    std::vector<Eigen::Matrix<double, 6, 1>> sums(stretches, Eigen::Matrix<double, 6, 1>::Zero());
    std::vector<double> samples(stretches, 0.0);
    for (std::size_t k = 0; k < residuals.times.size(); ++k) {
      const auto at = static_cast<std::size_t>((residuals.times[k] - start) / length);
      if (at >= stretches) break;
      sums[at] += residuals.values[k].cwiseQuotient(of_one);
      samples[at] += 1.0;
    }
    const double freedom = 3.0 * static_cast<double>(stretches);
    for (std::size_t sensor = 0; sensor < 2; ++sensor) {
      double squares = 0.0;
      for (std::size_t s = 0; s < stretches; ++s) {
        squares += sums[s].segment<3>(3 * static_cast<int>(sensor)).squaredNorm() / std::max(1.0, samples[s]);
      }
      const double found = squares / freedom / LargestByChance(freedom);
      if (found <= excess.variance[sensor]) continue;
      excess.variance[sensor] = found;
      excess.seconds[sensor] = length;
    }
  }
  return excess;
}

}  // namespace mlic
