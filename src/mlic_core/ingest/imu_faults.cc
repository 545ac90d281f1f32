#include "mlic_core/ingest/imu_faults.h"

#include <algorithm>
#include <iterator>
#include <map>

#include "mlic_core/common/order_statistics.h"

namespace mlic {
namespace {

constexpr double kFrozen = 0.1;                // s; from: guard, some ten samples
constexpr std::size_t kFewestFrozen = 5;       // samples in a row; from: guard
constexpr double kFrozenAxis = 0.5;            // s; from: guard, coarse readings at rest repeat for less
constexpr std::size_t kFewestFrozenAxis = 20;  // samples in a row; from: guard
constexpr std::size_t kFewestOtherLevels = 5;  // of an axis that goes on; from: guard
constexpr std::size_t kFewestSaturated = 20;   // from: guard
constexpr std::size_t kFewestLevels = 50;      // of different values: fewer are no sensor's; from: guard
constexpr double kSpike = 30.0;                // times the usual step from one to the next; from: guard
constexpr double kSmallestTurnSpike = 0.5;     // rad/s; from: guard, no rig does this for a single sample
constexpr double kSmallestForceSpike = 20.0;   // m/s^2; from: guard, a knock lasts for some milliseconds
constexpr double kLeastSpread = 0.01;  // rad/s, m/s^2; from: guard, below it rounding alone makes the levels

// Of the samples [begin, end) that one axis shows, at most as many as asked for.
std::size_t LevelsWithin(const std::vector<StampedImu>& samples, std::size_t begin, std::size_t end,
                         int axis) {
  std::vector<double> levels;
  for (std::size_t i = begin; i < end && levels.size() < kFewestOtherLevels; ++i) {
    const double value = AxisReading(samples[i], axis);
    if (std::find(levels.begin(), levels.end(), value) == levels.end()) levels.push_back(value);
  }
  return levels.size();
}

}  // namespace

std::string AxisName(int axis) {
  return std::string(axis < 3 ? "gyroscope " : "accelerometer ") + "xyz"[axis % 3];
}

std::vector<bool> FindFrozen(const std::vector<StampedImu>& samples) {
  std::vector<bool> frozen(samples.size(), false);
  for (std::size_t begin = 0, end = 1; begin < samples.size(); begin = end++) {
    while (end < samples.size() && samples[end].angular_velocity == samples[begin].angular_velocity &&
           samples[end].specific_force == samples[begin].specific_force) {
      ++end;
    }
    if (end - begin < kFewestFrozen || SecondsSince(samples[begin].stamp, samples[end - 1].stamp) < kFrozen) {
      continue;
    }
    std::fill(frozen.begin() + begin + 1, frozen.begin() + end, true);
  }
  return frozen;
}

std::vector<bool> FindSpikes(const std::vector<StampedImu>& samples, bool of_gyroscope) {
  std::vector<bool> spikes(samples.size(), false);
  const auto reading = [&](std::size_t i) -> const Eigen::Vector3d& {
    return of_gyroscope ? samples[i].angular_velocity : samples[i].specific_force;
  };
  // From one sample to the next.
  std::vector<double> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) steps.push_back((reading(i) - reading(i - 1)).norm());
  const double limit =
      std::max(of_gyroscope ? kSmallestTurnSpike : kSmallestForceSpike, kSpike * Median(steps));
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    spikes[i] = std::min(steps[i - 1], steps[i]) > limit &&
                (reading(i + 1) - reading(i - 1)).norm() < 0.5 * std::min(steps[i - 1], steps[i]);
  }
  return spikes;
}

std::vector<bool> FindSaturated(const std::vector<StampedImu>& samples, int axis) {
  std::vector<bool> saturated(samples.size(), false);
  std::map<double, std::size_t> counts;
  for (const StampedImu& sample : samples) ++counts[AxisReading(sample, axis)];
  if (counts.size() < kFewestLevels) return saturated;
  if (counts.rbegin()->first - counts.begin()->first < kLeastSpread) return saturated;
  const auto is_limit = [](std::size_t at, std::size_t next) {
    return at >= kFewestSaturated && at > 5 * next;
  };
  const bool low = is_limit(counts.begin()->second, std::next(counts.begin())->second);
  const bool high = is_limit(counts.rbegin()->second, std::next(counts.rbegin())->second);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double value = AxisReading(samples[i], axis);
    saturated[i] = (low && value == counts.begin()->first) || (high && value == counts.rbegin()->first);
  }
  return saturated;
}

std::vector<bool> FindFrozenAxis(const std::vector<StampedImu>& samples, int axis) {
  std::vector<bool> frozen(samples.size(), false);
  const int first = axis < 3 ? 0 : 3;
  for (std::size_t begin = 0, end = 1; begin < samples.size(); begin = end++) {
    const double value = AxisReading(samples[begin], axis);
    while (end < samples.size() && AxisReading(samples[end], axis) == value) ++end;
    if (end - begin < kFewestFrozenAxis) continue;
    if (SecondsSince(samples[begin].stamp, samples[end - 1].stamp) < kFrozenAxis) continue;
    for (int other = first; other < first + 3; ++other) {
      if (other == axis || LevelsWithin(samples, begin, end, other) < kFewestOtherLevels) continue;
      std::fill(frozen.begin() + begin, frozen.begin() + end, true);
    }
  }
  return frozen;
}

}  // namespace mlic
