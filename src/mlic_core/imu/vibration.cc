#include "mlic_core/imu/vibration.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mlic_core/common/time_interval.h"
#include "mlic_core/imu/imu_samples.h"
#include "mlic_core/imu/least_noise.h"
#include "mlic_core/imu/low_pass.h"
#include "mlic_core/imu/noise_spectrum.h"

namespace mlic {
namespace {

// Up to where a LowPass leaves what it is (2 * top): the splines' band, and twice that. The lower one where
// something shakes between them. from: derivation, half of the finest knots' rate is 12.5 Hz
constexpr std::array<double, 2> kTops{0.25 / kFinestKnots, 0.5 / kFinestKnots};  // Hz
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

  EvenSamples(const std::vector<ImuSample>& samples, double constant_period)
      : start(samples.front().time), period(constant_period) {
    const auto count = static_cast<Eigen::Index>((samples.back().time - start) / period);
    values.resize(count, 6);
    auto next = samples.begin() + 1;
    for (Eigen::Index k = 0; k < count; ++k) {
      const double time = start + static_cast<double>(k) * period;
      while (next->time < time) ++next;
      const double share = (time - (next - 1)->time) / (next->time - (next - 1)->time);
      values.row(k) = (1.0 - share) * ValuesOf(*(next - 1)).transpose() + share * ValuesOf(*next).transpose();
    }
  }
};

// From where on a filter lets nothing through, Hz: twice that is the rate of what it leaves.
double StopOf(double top) { return 3.0 * top; }

// Variance of an axis' noise over all frequencies, at the level of the octave below a filter's stop, or that
// of the best of IMUs.
double NoiseOf(const NoiseSpectrum& spectrum, bool of_rate, double stop) {
  const double density = of_rate ? kBestGyroscope : kBestAccelerometer;
  return std::max(density * density * 2.0 * spectrum.Nyquist(), spectrum.WhiteVariance(0.5 * stop, stop));
}

// Whether any axis shakes from the filter's stop up to `end` (Hz) more than noise at the level of the octave
// below, or of the best of IMUs.
bool Shakes(const std::array<NoiseSpectrum, 6>& axes, double top, double end) {
  const double stop = StopOf(top), nyquist = axes[0].Nyquist();
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    const double noise = NoiseOf(axes[axis], axis < 3, stop);
    if (axes[axis].Variance(stop, end) > kLeastExcess * noise * (end - stop) / nyquist) return true;
  }
  return false;
}

// The lowest that is needed, Hz; zero for none.
double TopOfFilter(const std::array<NoiseSpectrum, 6>& axes) {
  const double nyquist = axes[0].Nyquist();
  for (std::size_t k = 0; k < kTops.size(); ++k) {
    const double end = k + 1 < kTops.size() ? std::min(nyquist, StopOf(kTops[k + 1])) : nyquist;
    if (1.1 * StopOf(kTops[k]) < end && Shakes(axes, kTops[k], end)) return kTops[k];
  }
  return 0.0;
}

// Hz, of the rates' own low-pass behind a filter: it stops where splines with the finest knots that such
// samples allow (every two of them) end.
double TopOfRates(double top) { return 1.0 / (6.0 * std::max(kFinestKnots, 1.0 / StopOf(top))); }

// Whether any rate has in the octave above that more than noise: than that of any usual gyroscope, and than
// at its level beyond, up to which a noisier one's reaches as well.
bool TurnsFast(const std::array<NoiseSpectrum, 6>& axes, double top) {
  const double begin = StopOf(TopOfRates(top)), end = std::min(2.0 * begin, 2.0 * top);
  return std::any_of(axes.begin(), axes.begin() + 3, [&](const NoiseSpectrum& axis) {
    const double nyquist = axis.Nyquist();
    const double noise =
        std::max(kWorstGyroscope * kWorstGyroscope * 2.0 * nyquist, axis.WhiteVariance(end, nyquist));
    return axis.Variance(begin, end) > kLeastExcess * noise * (end - begin) / nyquist;
  });
}

// By how many lobes of a filter (s each) samples have to keep off a gap. In it the vibration is missing, of
// which next to it enters a sixth, and half of that a lobe further, and so on: no more than noise may.
double LobesOffGaps(const std::array<NoiseSpectrum, 6>& axes, double above) {
  constexpr double kShare = 1.0 / 6.0;  // from: measured, lines of 27 to 73 Hz, gaps of 7 to 200 samples
  double largest = 1.0;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    const double nyquist = axes[axis].Nyquist();
    const double noise = NoiseOf(axes[axis], axis < 3, above) * above / nyquist;
    largest = std::max(largest, kShare * std::sqrt(axes[axis].Variance(above, nyquist) / noise));
  }
  return 1.0 + std::log2(largest);
}

// What a low-pass makes of the samples at a time. reach: s to either side that it looks at most.
Values Smoothed(const EvenSamples& samples, const LowPass& filter, double time, double reach) {
  const double at = (time - samples.start) / samples.period;
  const double wide = std::min(filter.HalfWidth(), reach) / samples.period;
  double total = 0.0;
  Values sum = Values::Zero();
  for (double i = std::ceil(at - wide); i <= at + wide; i += 1.0) {
    const auto row = std::min(static_cast<Eigen::Index>(i), samples.values.rows() - 1);
    const double weight = filter.Weight((i - at) * samples.period);
    total += weight;
    sum += weight * samples.values.row(row).transpose();
  }
  return sum / total;
}

// Begins and ends of what is bridged and longer than that, s.
std::vector<TimeInterval> GapsOf(const std::vector<ImuSample>& samples, double longest) {
  std::vector<TimeInterval> gaps;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    if (samples[k].time - samples[k - 1].time > longest)
      gaps.push_back({samples[k - 1].time, samples[k].time});
  }
  return gaps;
}

// The samples at a rate (Hz), but for the ends, where a part of the filter is missing, and for gaps and what
// is nearer to them than off_gaps (s). What bridges a gap is off by what rises from zero at its edges, and
// slow as the motion is: the filter leaves it within. of_rates: their own filter, where they have one.
std::vector<ImuSample> Filter(const EvenSamples& even, const std::vector<ImuSample>& samples,
                              const LowPass& filter, const std::optional<LowPass>& of_rates, double off_gaps,
                              double rate) {
  const double half = filter.HalfWidth();
  const double last = even.start + static_cast<double>(even.values.rows() - 1) * even.period;
  const std::vector<TimeInterval> gaps = GapsOf(samples, LongestBridgedPeriod(even.period));
  std::vector<ImuSample> filtered;
  std::size_t gap = 0;
  for (double k = std::ceil((even.start + half) * rate); k / rate <= last - half; k += 1.0) {
    const double time = k / rate;
    while (gap < gaps.size() && gaps[gap].end + off_gaps < time) ++gap;
    if (gap < gaps.size() && time > gaps[gap].start - off_gaps) continue;
    // As wide to either side as the ends leave room for: steady slopes stay as they are.
    const double reach = std::min(time - even.start, last - time);
    Values values = Smoothed(even, filter, time, reach);
    if (of_rates) values.head<3>() = Smoothed(even, *of_rates, time, reach).head<3>();
    filtered.push_back({time, values.head<3>(), values.tail<3>()});
  }
  return filtered;
}

}  // namespace

std::optional<FilteredImu> WithoutVibration(const std::vector<ImuSample>& samples) {
  if (samples.size() < 2) return std::nullopt;
  // Not the median, of which stamps that come in pairs could make any number of even samples.
  const double period =
      (samples.back().time - samples.front().time) / static_cast<double>(samples.size() - 1);
  const EvenSamples even(samples, period);
  std::array<NoiseSpectrum, 6> axes;
  for (int axis = 0; axis < 6; ++axis) axes[axis] = NoiseSpectrum(even.values.col(axis), 1.0 / period);
  double top = TopOfFilter(axes);
  FilteredImu filtered;
  const double finest = top > 0.0 ? top : kTops.back();
  if (1.1 * StopOf(finest) < axes[0].Nyquist() && TurnsFast(axes, finest)) {
    top = finest;
    filtered.turns_above = StopOf(TopOfRates(top));
    for (int axis = 0; axis < 3; ++axis) {
      filtered.fast_turns =
          std::max(filtered.fast_turns, std::sqrt(axes[axis].Variance(filtered.turns_above, StopOf(top))));
    }
  }
  if (top == 0.0) return std::nullopt;
  filtered.above = StopOf(top);
  for (int axis = 0; axis < 6; ++axis) {
    double& largest = axis < 3 ? filtered.angular_velocity : filtered.specific_force;
    largest = std::max(largest, std::sqrt(axes[axis].Variance(filtered.above, axes[axis].Nyquist())));
  }
  const LowPass filter(top);
  std::optional<LowPass> of_rates;
  if (filtered.turns_above > 0.0) of_rates.emplace(TopOfRates(top));
  const double rate = 2.0 * StopOf(top);
  const double off_gaps =
      std::min(filter.HalfWidth(), LobesOffGaps(axes, filtered.above) * filter.MainLobe());
  filtered.samples = Filter(even, samples, filter, of_rates, off_gaps, rate);
  const double kept = static_cast<double>(filtered.samples.size()) / rate;
  if (kept < kLeastKept * static_cast<double>(samples.size()) * period) return std::nullopt;
  return filtered;
}

}  // namespace mlic
