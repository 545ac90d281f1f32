#include "mlic_core/uncertainty/stretch_means.h"

#include <algorithm>
#include <cmath>

namespace mlic {
namespace {

// A mean of so many squares of standard normal variates is beyond it by chance once in 700 (Wilson and
// Hilferty, 1931).
double LargestByChance(double freedom) {
  constexpr double kChance = 3.0;  // standard deviations; from: derivation, 1 in 700
  const double spread = 2.0 / (9.0 * freedom);
  return std::pow(1.0 - spread + kChance * std::sqrt(spread), 3);
}

}  // namespace

StretchMeans::StretchMeans(const ImuResiduals& residuals, const ImuSigmaCourse& sigma, double length) {
  const double start = residuals.times.front();
  constexpr double kRounding = 1e-9;  // of a stretch; from: guard, a length that divides the drive
  const auto count = static_cast<std::size_t>((residuals.times.back() - start) / length + kRounding);
  sums_.assign(count, Mean::Zero());
  weights_.assign(count, Mean::Zero());
  for (std::size_t k = 0; k < residuals.times.size(); ++k) {
    const auto at = static_cast<std::size_t>((residuals.times[k] - start) / length);
    if (at >= count) break;
    const ImuSigma of_sample = sigma.At(residuals.times[k]);
    Mean weight;
    weight << of_sample.gyroscope.cwiseAbs2().cwiseInverse(),
        of_sample.accelerometer.cwiseAbs2().cwiseInverse();
    sums_[at] += weight.cwiseProduct(residuals.values[k]);
    weights_[at] += weight;
  }
}

StretchMeans::Mean StretchMeans::Of(std::size_t stretch) const {
  return (weights_[stretch].array() > 0.0).select(sums_[stretch].cwiseQuotient(weights_[stretch]), 0.0);
}

double StretchMeans::Excess(int first) const {
  double squares = 0.0;
  for (std::size_t s = 0; s < sums_.size(); ++s) {
    squares += Of(s).cwiseProduct(sums_[s]).segment<3>(first).sum();
  }
  const double freedom = 3.0 * static_cast<double>(sums_.size());
  return squares / freedom / LargestByChance(freedom);
}

}  // namespace mlic
