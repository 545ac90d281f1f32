#include "mlic_core/uncertainty/stamp_wander.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"

namespace mlic {
namespace {

constexpr std::size_t kFewest = 20;  // scans that say something; from: guard
constexpr double kShown = 9.0;       // twice a logarithm of likelihoods; from: derivation, three sigmas
constexpr double kStartVariance =
    1e-4;  // s^2, of the first shift; from: guard, 10 ms, no course starts so far off
constexpr double kMedianOfSquares = 0.4549;  // from: standard, of a squared standard normal variable

// Time errors of single scans with the variance of their noise.
struct Errors {
  std::vector<double> times, values, variances;
};

// Noise is at least as large as claimed, and as neighbours scatter about each other.
Errors ErrorsOf(const ScanSums& scans) {
  Errors errors;
  for (const auto& [time, sum] : scans) {
    if (sum.information <= 0.0) continue;
    errors.times.push_back(time);
    errors.values.push_back(sum.gradient / sum.information);
    errors.variances.push_back(1.0 / sum.information);
  }
  std::vector<double> squares;
  for (std::size_t k = 1; k < errors.times.size(); ++k) {
    const double difference = errors.values[k] - errors.values[k - 1];
    squares.push_back(difference * difference / (errors.variances[k] + errors.variances[k - 1]));
  }
  if (squares.empty()) return errors;
  const double scatter = std::max(1.0, Median(std::move(squares)) / kMedianOfSquares);
  for (double& variance : errors.variances) variance *= scatter;
  return errors;
}

// Kalman's filter of a random walk.
struct Filtered {
  std::vector<double> means, variances;  // of each time, with what came until then
  double likelihood = 0.0;               // twice its logarithm, but for a constant
};

Filtered Filter(const Errors& errors, double walk) {
  Filtered filtered;
  double mean = 0.0, variance = kStartVariance;
  for (std::size_t k = 0; k < errors.times.size(); ++k) {
    if (k > 0) variance += walk * (errors.times[k] - errors.times[k - 1]);
    const double innovation = errors.values[k] - mean, expected = variance + errors.variances[k];
    filtered.likelihood -= innovation * innovation / expected + std::log(expected);
    const double gain = variance / expected;
    mean += gain * innovation;
    variance *= 1.0 - gain;
    filtered.means.push_back(mean);
    filtered.variances.push_back(variance);
  }
  return filtered;
}

std::vector<double> Smoothed(const Errors& errors, double walk) {
  const Filtered filtered = Filter(errors, walk);
  std::vector<double> means = filtered.means;
  for (std::size_t k = means.size() - 1; k-- > 0;) {
    const double ahead = filtered.variances[k] + walk * (errors.times[k + 1] - errors.times[k]);
    means[k] += filtered.variances[k] / ahead * (means[k + 1] - filtered.means[k]);
  }
  return means;
}

void RemoveMeanAndSlope(StampCourse* course) {
  const auto count = static_cast<double>(course->times.size());
  double mean_time = 0.0, mean = 0.0;
  for (std::size_t k = 0; k < course->times.size(); ++k) {
    mean_time += course->times[k] / count;
    mean += course->shifts[k] / count;
  }
  double moment = 0.0, product = 0.0;
  for (std::size_t k = 0; k < course->times.size(); ++k) {
    const double from_mean = course->times[k] - mean_time;
    moment += from_mean * from_mean;
    product += from_mean * course->shifts[k];
  }
  for (std::size_t k = 0; k < course->times.size(); ++k) {
    course->shifts[k] -= mean + product / moment * (course->times[k] - mean_time);
  }
}

}  // namespace

std::optional<StampCourse> FindStampCourse(const ScanSums& scans, bool known) {
  const Errors errors = ErrorsOf(scans);
  if (errors.times.size() < kFewest) return std::nullopt;
  const double without = Filter(errors, 0.0).likelihood;
  double best = without + (known ? 0.0 : kShown), walk = 0.0;
  // s/sqrt(s); from: guard, from what no drive shows to what no camera has
  constexpr double kLeast = 1e-6, kMost = 1e-2, kStep = 1.3;
  for (double size = kLeast; size < kMost; size *= kStep) {
    const double likelihood = Filter(errors, size * size).likelihood;
    if (likelihood > best) best = likelihood, walk = size * size;
  }
  if (walk == 0.0) return std::nullopt;
  StampCourse course{errors.times, Smoothed(errors, walk), walk};
  RemoveMeanAndSlope(&course);
  return course;
}

}  // namespace mlic
