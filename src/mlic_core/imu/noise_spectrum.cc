#include "mlic_core/imu/noise_spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "mlic_core/common/order_statistics.h"

namespace mlic {

NoiseSpectrum::NoiseSpectrum(const Eigen::VectorXd& values, double rate) : nyquist_(0.5 * rate) {
  // Lengths with many small factors: others take the transform long.
  const auto all = static_cast<std::size_t>(values.size());
  const std::size_t unit = all < 16384 ? 64 : 1024;
  count_ = all / unit * unit;
  if (count_ == 0) return;
  step_ = rate / static_cast<double>(count_);
  const double mean = values.head(static_cast<Eigen::Index>(count_)).mean();
  std::vector<double> windowed(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    const double window = 1.0 - std::cos(2.0 * M_PI * (static_cast<double>(i) + 0.5) / count_);
    windowed[i] = window / std::sqrt(1.5) * (values[static_cast<Eigen::Index>(i)] - mean);
  }
  std::vector<std::complex<double>> transform;
  Eigen::FFT<double>().fwd(transform, windowed);
  for (std::size_t i = 0; i <= count_ / 2; ++i) level_.push_back(std::norm(transform[i]) / count_);
}

std::size_t NoiseSpectrum::Bin(double frequency) const {
  return std::min(level_.size(), static_cast<std::size_t>(std::max(0.0, std::ceil(frequency / step_))));
}

double NoiseSpectrum::Variance(double low, double high) const {
  double sum = 0.0;
  for (std::size_t i = Bin(low); i < Bin(high); ++i) sum += 2.0 * level_[i] / static_cast<double>(count_);
  return sum;
}

double NoiseSpectrum::WhiteVariance(double low, double high) const {
  const std::size_t begin = Bin(low), end = Bin(high);
  if (begin >= end) return 0.0;
  // Levels of noise are distributed exponentially.
  return Median(std::vector<double>(level_.begin() + static_cast<std::ptrdiff_t>(begin),
                                    level_.begin() + static_cast<std::ptrdiff_t>(end))) /
         std::log(2.0);
}

double TopOfBand(double rate, double knot_spacing) { return std::min(0.25 * rate, 0.5 / knot_spacing); }

}  // namespace mlic
