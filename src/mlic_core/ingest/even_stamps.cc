#include "mlic_core/ingest/even_stamps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/imu/robust.h"
#include "mlic_core/ingest/imu_faults.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {
namespace {

constexpr std::size_t kFewest = 400;  // samples; from: guard, two seconds of most IMUs
// Samples to either side of a lost message; from: guard, their scatter of a period tells it by 8 sigmas.
constexpr std::size_t kBeside = 100;
constexpr double kHalf = 1.0;  // s, to either side of a line's middle; from: guard, clocks are steady
constexpr double kLeastScatter = 0.01;  // periods; from: guard, less moves no reading by its noise

// Median of [begin, end).
double MedianOf(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  return Median(std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(begin),
                                    values.begin() + static_cast<std::ptrdiff_t>(end)));
}

double PeriodOf(const std::vector<double>& times) {
  constexpr std::size_t kStep = 100;  // from: guard, few of so many samples hold a lost message
  std::vector<double> periods;
  for (std::size_t k = kStep; k < times.size(); k += kStep / 2) {
    periods.push_back((times[k] - times[k - kStep]) / kStep);
  }
  return Median(periods);
}

// Where values step from one level to another, of the indices [begin, end]: by least absolute deviations.
std::size_t StepOf(const std::vector<double>& values, std::size_t begin, std::size_t end, double level,
                   double further) {
  double sum = 0.0, least = 0.0;
  std::size_t best = begin;
  for (std::size_t k = begin; k < end; ++k) {
    sum += std::abs(values[k] - level) - std::abs(values[k] - further);
    if (sum >= least) continue;
    least = sum;
    best = k + 1;
  }
  return best;
}

// The periods from the first sample to each.
std::vector<double> Count(const std::vector<double>& times, double period) {
  constexpr std::size_t kEvery = 10;  // from: guard, time: a step is seen when half the samples are behind it
  std::vector<double> counts, beyond;  // beyond: what stamps are later than so many periods
  double lost = 0.0;
  const auto count_to = [&](std::size_t end) {
    for (std::size_t k = counts.size(); k < std::min(end, times.size()); ++k) {
      counts.push_back(static_cast<double>(k) + lost);
      beyond.push_back(times[k] - period * counts[k]);
    }
  };
  for (std::size_t k = kBeside; k + kBeside <= times.size(); k += kEvery) {
    count_to(k + kBeside);
    const double before = MedianOf(beyond, k - kBeside, k);
    const double step = std::round((MedianOf(beyond, k, k + kBeside) - before) / period);
    if (step < 1.0) continue;
    lost += step;
    for (std::size_t j = StepOf(beyond, k, k + kBeside, before, before + step * period); j < counts.size();
         ++j) {
      counts[j] += step;
      beyond[j] -= step * period;
    }
  }
  count_to(times.size());
  return counts;
}

struct Line {
  double middle = 0.0;  // of the counts
  double time = 0.0;    // there, s
  double period = 0.0;  // s

  double At(double count) const { return time + period * (count - middle); }
};

// By least absolute values, through [begin, end).
Line FitLine(const std::vector<double>& counts, const std::vector<double>& times, std::size_t begin,
             std::size_t end, double period) {
  Line line{0.5 * (counts[begin] + counts[end - 1]), 0.0, period};
  std::vector<double> weights(end - begin, 1.0);
  for (int iteration = 0; iteration < 10; ++iteration) {
    double sum = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      const double weight = weights[k - begin], c = counts[k] - line.middle;
      sum += weight;
      x += weight * c;
      y += weight * times[k];
      xx += weight * c * c;
      xy += weight * c * times[k];
    }
    const double determinant = sum * xx - x * x;
    if (!(determinant > 0.0)) return line;
    line.period = (sum * xy - x * y) / determinant;
    line.time = (y - line.period * x) / sum;
    for (std::size_t k = begin; k < end; ++k) {
      weights[k - begin] = AbsoluteWeight(std::abs(times[k] - line.At(counts[k])), 0.01 * period);
    }
  }
  return line;
}

// Lines through a second to either side of every second; from one to the next the share of each changes
// evenly.
std::vector<double> EvenTimes(const std::vector<double>& counts, const std::vector<double>& times,
                              double period) {
  const auto parts =
      static_cast<std::size_t>(std::max(1.0, std::floor((times.back() - times.front()) / kHalf)));
  const double step = (counts.back() - counts.front()) / static_cast<double>(parts);
  std::vector<Line> lines;
  for (std::size_t i = 0; i <= parts; ++i) {
    const double middle = counts.front() + step * static_cast<double>(i);
    const auto at = [&](double count) {
      return static_cast<std::size_t>(std::lower_bound(counts.begin(), counts.end(), count) - counts.begin());
    };
    const std::size_t begin = at(middle - step), end = at(middle + step);
    lines.push_back(end > begin + kBeside || lines.empty() ? FitLine(counts, times, begin, end, period)
                                                           : lines.back());
  }
  std::vector<double> even;
  for (const double count : counts) {
    const double along = (count - counts.front()) / step;
    const std::size_t i = std::min(static_cast<std::size_t>(along), parts - 1);
    const double share = along - static_cast<double>(i);
    even.push_back((1.0 - share) * lines[i].At(count) + share * lines[i + 1].At(count));
  }
  return even;
}

// What each reading of an axis is off the cubic through two neighbours to either side, over how much noise
// such an error has. samples: in order of time.
std::vector<double> Roughness(const std::vector<ImuSample>& samples, int axis) {
  constexpr std::array<int, 4> kNeighbours{-2, -1, 1, 2};
  std::vector<double> errors;
  for (std::size_t k = 2; k + 2 < samples.size(); ++k) {
    double error = AxisReading(samples[k], axis), noise = 1.0;
    for (const int i : kNeighbours) {
      double weight = 1.0;
      for (const int j : kNeighbours) {
        if (j == i) continue;
        weight *= (samples[k].time - samples[k + j].time) / (samples[k + i].time - samples[k + j].time);
      }
      error -= weight * AxisReading(samples[k + i], axis);
      noise += weight * weight;
    }
    errors.push_back(error / std::sqrt(noise));
  }
  return errors;
}

// In order of these times, no two of which are alike.
std::vector<ImuSample> InOrder(std::vector<ImuSample> samples, const std::vector<double>& times) {
  constexpr double kApart = 1e-6;  // s; from: guard, against division by zero
  for (std::size_t k = 0; k < times.size(); ++k) samples[k].time = times[k];
  std::stable_sort(samples.begin(), samples.end(),
                   [](const ImuSample& a, const ImuSample& b) { return a.time < b.time; });
  for (std::size_t k = 1; k < samples.size(); ++k) {
    samples[k].time = std::max(samples[k].time, samples[k - 1].time + kApart);
  }
  return samples;
}

// Whether all axes together are smoother at the even times, by far more than chance.
bool AreSmootherAt(const std::vector<double>& even, const std::vector<double>& given,
                   const std::vector<ImuSample>& samples) {
  constexpr double kOutlier = 5.0;  // sigmas; from: guard
  // Of the sum of squares: errors of neighbours depend on each other, three at a time. from: derivation
  const double chance = 5.0 * std::sqrt(3.0 * 2.0 * kImuAxes * static_cast<double>(samples.size()));
  const std::vector<ImuSample> now = InOrder(samples, even), before = InOrder(samples, given);
  double gain = 0.0;
  for (int axis = 0; axis < kImuAxes; ++axis) {
    const std::vector<double> errors = Roughness(now, axis), errors_before = Roughness(before, axis);
    std::vector<double> sizes;
    for (const double error : errors) sizes.push_back(std::abs(error));
    const double sigma = 1.4826 * Median(sizes);  // from: derivation, of normal errors
    if (!(sigma > 0.0)) continue;
    const auto cost = [&](double error) { return std::min(std::pow(error / sigma, 2), kOutlier * kOutlier); };
    for (std::size_t k = 0; k < errors.size(); ++k) gain += cost(errors_before[k]) - cost(errors[k]);
  }
  return gain > chance;
}

// Indices of the samples that count: finite, and not the one before once more.
std::vector<std::size_t> Counted(const std::vector<StampedImu>& samples) {
  std::vector<std::size_t> counted;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const StampedImu& sample = samples[k];
    const bool again = k > 0 && sample.angular_velocity == samples[k - 1].angular_velocity &&
                       sample.specific_force == samples[k - 1].specific_force;
    if (!again && sample.angular_velocity.allFinite() && sample.specific_force.allFinite()) {
      counted.push_back(k);
    }
  }
  return counted;
}

}  // namespace

std::optional<EvenStamps> FindEvenStamps(const std::vector<StampedImu>& samples) {
  const std::vector<std::size_t> counted = Counted(samples);
  if (counted.size() < kFewest) return std::nullopt;
  const TimeNs epoch = samples[counted[0]].stamp;
  std::vector<double> times;
  std::vector<ImuSample> readings;
  for (const std::size_t k : counted) {
    times.push_back(SecondsSince(epoch, samples[k].stamp));
    readings.push_back({times.back(), samples[k].angular_velocity, samples[k].specific_force});
  }
  const double period = PeriodOf(times);
  if (!(period > 0.0)) return std::nullopt;
  const std::vector<double> even = EvenTimes(Count(times, period), times, period);
  EvenStamps result;
  std::vector<double> errors;
  for (std::size_t k = 0; k < times.size(); ++k) {
    errors.push_back(times[k] - even[k]);
    result.late += errors.back() * errors.back() / static_cast<double>(times.size());
    result.latest = std::max(result.latest, errors.back());
    if (k > 0 && even[k] <= even[k - 1]) return std::nullopt;
  }
  result.late = std::sqrt(result.late);
  // Miscounted, stamps would be whole periods off for long.
  for (std::size_t k = 0; k + kBeside <= errors.size(); k += kBeside) {
    if (std::abs(MedianOf(errors, k, k + kBeside)) > 0.5 * period) return std::nullopt;
  }
  if (result.late < kLeastScatter * period || !AreSmootherAt(even, times, readings)) return std::nullopt;
  std::size_t next = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (next < counted.size() && counted[next] == k) ++next;
    const double time = even[std::max<std::size_t>(1, next) - 1];
    result.stamps.push_back(epoch + static_cast<TimeNs>(std::llround(1e9 * time)));
  }
  return result;
}

}  // namespace mlic
