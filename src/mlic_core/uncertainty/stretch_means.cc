#include "mlic_core/uncertainty/stretch_means.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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

StretchMeans::StretchMeans(const ImuResiduals& residuals, const ImuSigma& sigma, double length) {
  sigma_ << sigma.gyroscope, sigma.accelerometer;
  const double start = residuals.times.front();
  constexpr double kRounding = 1e-9;  // of a stretch; from: guard, a length that divides the drive
  const auto count = static_cast<std::size_t>((residuals.times.back() - start) / length + kRounding);
  sums_.assign(count, Mean::Zero());
  samples_.assign(count, 0.0);
  for (std::size_t k = 0; k < residuals.times.size(); ++k) {
    const auto at = static_cast<std::size_t>((residuals.times[k] - start) / length);
    if (at >= count) break;
    sums_[at] += residuals.values[k];
    samples_[at] += 1.0;
  }
}

StretchMeans::Mean StretchMeans::Of(std::size_t stretch) const {
  return sums_[stretch] / std::max(1.0, samples_[stretch]);
}

StretchMeans::Mean StretchMeans::Noise() const {
  const double samples = std::accumulate(samples_.begin(), samples_.end(), 0.0);
  return sigma_ / std::sqrt(std::max(1.0, samples / static_cast<double>(Count())));
}

double StretchMeans::Excess(int first) const {
  double squares = 0.0;
  for (std::size_t s = 0; s < Count(); ++s) {
    squares += sums_[s].cwiseQuotient(sigma_).segment<3>(first).squaredNorm() / std::max(1.0, samples_[s]);
  }
  const double freedom = 3.0 * static_cast<double>(Count());
  return squares / freedom / LargestByChance(freedom);
}

}  // namespace mlic
