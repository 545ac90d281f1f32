#include "mlic_core/ingest/imu_check.h"

#include <algorithm>
#include <sstream>

#include "mlic_core/common/error.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/ingest/imu_faults.h"

namespace mlic {
namespace {

// from: guard, g in m/s^2 is 9.8, in g is 1.
constexpr double kLeastForce = 6.0, kMostForce = 20.0;  // m/s^2, median of a drive
constexpr double kFastestMedianTurn = 6.0;              // rad/s; from: guard, deg/s are 57 times rad/s
constexpr double kFastestTurn = 35.0;  // rad/s, 2000 deg/s; from: standard, the range of common gyroscopes

template <typename Norm>
std::vector<double> Norms(const std::vector<StampedImu>& samples, const Norm& norm) {
  std::vector<double> values;
  for (const StampedImu& sample : samples) values.push_back(norm(sample));
  return values;
}

void CheckForce(const std::vector<StampedImu>& samples, const std::string& topic) {
  const double force = Quantile(Norms(samples, [](const auto& s) { return s.specific_force.norm(); }), 0.5);
  if (force >= kLeastForce && force <= kMostForce) return;
  std::ostringstream text;
  text << "topic " << topic << ": the median of |linear_acceleration| is " << force
       << ", expected about 9.8 (specific force in m/s^2, with gravity)";
  if (force > 0.7 && force < 1.5) {
    text << "; it looks like g: multiply by 9.80665";
  } else if (force < kLeastForce) {
    text << "; it looks as if gravity had been removed: record the raw acceleration";
  } else if (force > 700.0 && force < 1500.0) {
    text << "; it looks like thousandths of g: multiply by 0.00980665";
  } else {
    text << "; correct the unit";
  }
  throw InputError(text.str());
}

void CheckTurnRate(const std::vector<StampedImu>& samples, const std::string& topic) {
  const std::vector<double> rates = Norms(samples, [](const auto& s) { return s.angular_velocity.norm(); });
  const double median = Quantile(rates, 0.5), high = Quantile(rates, 0.98);
  if (median <= kFastestMedianTurn && high <= kFastestTurn) return;
  std::ostringstream text;
  text << "topic " << topic << ": |angular_velocity| has a median of " << median << " and reaches " << high
       << ", which no vehicle turns in rad/s; it looks like deg/s: multiply by 0.0174533";
  throw InputError(text.str());
}

void DropUnmeasured(std::vector<StampedImu>& samples, ImuCounts* counts) {
  std::vector<bool> frozen = FindFrozen(samples), broken(samples.size(), false), saturated = broken;
  for (int axis = 0; axis < kImuAxes; ++axis) {
    const std::vector<bool> at_limit = FindSaturated(samples, axis);
    const std::vector<bool> stuck = FindFrozenAxis(samples, axis);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      saturated[i] = saturated[i] || at_limit[i];
      broken[i] = broken[i] || stuck[i];
      if (stuck[i]) ++counts->frozen_axes[axis];
    }
  }
  const std::vector<bool> turns = FindSpikes(samples, true), forces = FindSpikes(samples, false);
  const auto count = static_cast<std::size_t>(std::count(frozen.begin(), frozen.end(), true));
  if (2 * count > samples.size()) std::fill(frozen.begin(), frozen.end(), false);
  std::vector<StampedImu> kept;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (frozen[i]) {
      ++counts->frozen;
    } else if (saturated[i]) {
      ++counts->saturated;
    } else if (turns[i] || forces[i]) {
      ++counts->spikes;
    } else if (!broken[i]) {
      kept.push_back(samples[i]);
    }
  }
  samples = std::move(kept);
}

}  // namespace

ImuCounts CleanImu(std::vector<StampedImu>& samples, const std::string& topic) {
  ImuCounts counts;
  const std::size_t all = samples.size();
  samples.erase(std::remove_if(samples.begin(), samples.end(),
                               [](const StampedImu& sample) {
                                 return !sample.angular_velocity.allFinite() ||
                                        !sample.specific_force.allFinite();
                               }),
                samples.end());
  counts.not_finite = all - samples.size();
  if (samples.empty()) {
    throw InputError("topic " + topic + ": " +
                     (all == 0 ? "no IMU samples in the chosen time"
                               : "all " + std::to_string(all) + " IMU samples hold NaN or infinite values") +
                     "; expected angular_velocity and linear_acceleration");
  }
  std::stable_sort(samples.begin(), samples.end(),
                   [](const StampedImu& a, const StampedImu& b) { return a.stamp < b.stamp; });
  const auto last = std::unique(samples.begin(), samples.end(),
                                [](const StampedImu& a, const StampedImu& b) { return a.stamp == b.stamp; });
  counts.duplicates = static_cast<std::size_t>(samples.end() - last);
  samples.erase(last, samples.end());
  CheckForce(samples, topic);
  CheckTurnRate(samples, topic);
  DropUnmeasured(samples, &counts);
  return counts;
}

}  // namespace mlic
