#include "mlic_ros/imu_check.h"

#include <algorithm>
#include <sstream>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

constexpr double kLeastForce = 6.0, kMostForce = 20.0;  // m/s^2, median of a drive
constexpr double kFastestMedianTurn = 6.0;              // rad/s
constexpr double kFastestTurn = 35.0;                   // rad/s, 2000 deg/s: the range of common gyroscopes

// The value that `share` of the samples stay below.
template <typename Norm>
double Quantile(const std::vector<StampedImu>& samples, double share, const Norm& norm) {
  std::vector<double> values;
  for (const StampedImu& sample : samples) values.push_back(norm(sample));
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void CheckForce(const std::vector<StampedImu>& samples, const std::string& topic) {
  const double force = Quantile(samples, 0.5, [](const auto& s) { return s.specific_force.norm(); });
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
  const auto norm = [](const auto& s) { return s.angular_velocity.norm(); };
  const double median = Quantile(samples, 0.5, norm);
  const double high = Quantile(samples, 0.98, norm);
  if (median <= kFastestMedianTurn && high <= kFastestTurn) return;
  std::ostringstream text;
  text << "topic " << topic << ": |angular_velocity| has a median of " << median << " and reaches " << high
       << ", which no vehicle turns in rad/s; it looks like deg/s: multiply by 0.0174533";
  throw InputError(text.str());
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
  return counts;
}

}  // namespace mlic
