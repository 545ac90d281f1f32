#include "mlic_core/imu/vibration.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/imu/imu_samples.h"
#include "mlic_core/imu/low_pass.h"
#include "mlic_core/imu/noise_spectrum.h"

namespace mlic {
namespace {

constexpr double kTop = 0.5 / kFinestKnots;  // Hz; from: derivation, half of the knots' rate
constexpr double kAbove = 3.0 * kTop;  // Hz; from: derivation, from here on LowPass lets nothing through
constexpr double kRate = 8.0 * kTop;   // Hz; from: structural, above twice kAbove
// Of levels of the spectrum; from: derivation, less widens the sigmas of slow signals by less than 1.4
constexpr double kLeastExcess = 2.0;
// Of the drive: gaps, each of which takes the filter's width with it, may not leave less. from: guard
constexpr double kLeastKept = 0.9;

using Values = Eigen::Matrix<double, 6, 1>;

Values ValuesOf(const ImuSample& sample) {
  Values values;
  values << sample.angular_velocity, sample.specific_force;
  return values;
}

// From the start on at a constant period (s), one row for each time, in lines from sample to sample: lost
// ones would look like steps.
struct EvenSamples {
  double start, period;
  Eigen::MatrixXd values;

  EvenSamples(const ImuSample* begin, const ImuSample* end, double constant_period)
      : start(begin->time), period(constant_period) {
    const auto count = static_cast<Eigen::Index>(((end - 1)->time - start) / period);
    values.resize(count, 6);
    const ImuSample* next = begin + 1;
    for (Eigen::Index k = 0; k < count; ++k) {
      const double time = start + static_cast<double>(k) * period;
      while (next->time < time) ++next;
      const double share = (time - (next - 1)->time) / (next->time - (next - 1)->time);
      values.row(k) = (1.0 - share) * ValuesOf(*(next - 1)).transpose() + share * ValuesOf(*next).transpose();
    }
  }
};

// Variances of what lies above kAbove where any exceeds its noise by enough, otherwise nullopt.
std::optional<Values> FindVibration(const EvenSamples& samples) {
  const double rate = 1.0 / samples.period, nyquist = 0.5 * rate;
  Values variances;
  bool any = false;
  for (int axis = 0; axis < 6; ++axis) {
    const NoiseSpectrum spectrum(samples.values.col(axis), rate);
    variances[axis] = spectrum.Variance(kAbove, nyquist);
    const double noise = spectrum.WhiteVariance(kTop, 2.0 * kTop) * (nyquist - kAbove) / nyquist;
    any |= noise > 0.0 && variances[axis] > kLeastExcess * noise;
  }
  return any ? std::optional<Values>(variances) : std::nullopt;
}

// Adds those samples that have the whole filter within the given ones.
void Filter(const EvenSamples& samples, const LowPass& filter, std::vector<ImuSample>* filtered) {
  const double half = filter.HalfWidth();
  const double last = samples.start + static_cast<double>(samples.values.rows() - 1) * samples.period;
  for (double k = std::ceil((samples.start + half) * kRate); k / kRate <= last - half; k += 1.0) {
    const double time = k / kRate, at = (time - samples.start) / samples.period;
    const double reach = half / samples.period;
    double total = 0.0;
    Values sum = Values::Zero();
    for (double i = std::ceil(at - reach); i <= at + reach; i += 1.0) {
      const auto row = std::min(static_cast<Eigen::Index>(i), samples.values.rows() - 1);
      const double weight = filter.Weight((i - at) * samples.period);
      total += weight;
      sum += weight * samples.values.row(row).transpose();
    }
    sum /= total;
    filtered->push_back({time, sum.head<3>(), sum.tail<3>()});
  }
}

}  // namespace

std::optional<FilteredImu> WithoutVibration(const std::vector<ImuSample>& samples) {
  if (samples.size() < 2) return std::nullopt;
  const double period = MedianPeriod(samples);
  if (1.0 / period < kRate) return std::nullopt;
  const ImuSample* const end = samples.data() + samples.size();
  const std::optional<Values> variances = FindVibration({samples.data(), end, period});
  if (!variances) return std::nullopt;
  FilteredImu filtered;
  filtered.above = kAbove;
  filtered.angular_velocity = std::sqrt(variances->head<3>().maxCoeff());
  filtered.specific_force = std::sqrt(variances->tail<3>().maxCoeff());
  const LowPass filter(kTop);
  const double longest = LongestBridgedPeriod(period);
  for (const ImuSample* begin = samples.data(); begin != end;) {
    const ImuSample* next = begin + 1;
    while (next != end && next->time - (next - 1)->time <= longest) ++next;
    if ((next - 1)->time - begin->time > 2.0 * filter.HalfWidth()) {
      Filter({begin, next, period}, filter, &filtered.samples);
    }
    begin = next;
  }
  const double kept = static_cast<double>(filtered.samples.size()) / kRate;
  if (kept < kLeastKept * static_cast<double>(samples.size()) * period) return std::nullopt;
  return filtered;
}

}  // namespace mlic
