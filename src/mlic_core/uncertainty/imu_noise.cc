#include "mlic_core/uncertainty/imu_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/imu/noise_spectrum.h"
#include "mlic_core/uncertainty/stretch_means.h"

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
  const double duration = residuals.times.back() - residuals.times.front();
  for (const double length : kLengths) {
    if (duration < 2.0 * length) break;
    const StretchMeans means(residuals, sigma, length);
    for (int sensor = 0; sensor < 2; ++sensor) {
      const double found = means.Excess(3 * sensor);
      if (found <= excess.variance[sensor]) continue;
      excess.variance[sensor] = found;
      excess.seconds[sensor] = length;
    }
  }
  return excess;
}

}  // namespace mlic
