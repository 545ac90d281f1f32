#include "mlic_core/imu/imu_samples.h"

#include <algorithm>

#include "mlic_core/common/error.h"

namespace mlic {

std::vector<ImuSample> OrderedFiniteSamples(const std::vector<ImuSample>& samples) {
  std::vector<ImuSample> kept;
  kept.reserve(samples.size());
  for (const ImuSample& sample : samples) {
    if (!std::isfinite(sample.time) || !sample.angular_velocity.allFinite() ||
        !sample.specific_force.allFinite()) {
      continue;
    }
    if (!kept.empty() && sample.time <= kept.back().time) continue;
    kept.push_back(sample);
  }
  if (kept.size() < 4) {
    throw InputError(
        "IMU: only " + std::to_string(kept.size()) +
        " usable samples, at least 4 with finite values and increasing stamps are needed; check the IMU "
        "topic and the chosen part of the drive");
  }
  return kept;
}

double LongestBridgedPeriod(double median_period) { return std::max(4.0 * median_period, 0.03); }

}  // namespace mlic
