#pragma once

#include <array>
#include <string>
#include <vector>

#include "mlic_core/ingest/imu_faults.h"
#include "mlic_core/ingest/stamped_imu.h"

namespace mlic {

struct ImuCounts {
  std::size_t not_finite = 0;
  std::size_t duplicates = 0;
  std::size_t frozen = 0;                           // a driver that hangs repeats its last reading
  std::array<std::size_t, kImuAxes> frozen_axes{};  // one axis repeats its reading while others go on
  std::size_t saturated = 0;                        // an axis at the end of its range
  std::size_t spikes = 0;                           // a single reading far off its neighbours
};

// Drops samples that are not finite, sorts by stamp, drops repeated stamps and what is not measured (frozen
// and saturated readings, spikes, and those with a frozen axis; where nearly all are alike, as in a
// simulation without noise, none counts as frozen), and checks the units: specific force in m/s^2 with
// gravity in it, angular velocity in rad/s. Throws InputError, starting with the topic, when nothing finite
// is left or when a unit is wrong, saying which one it looks like.
ImuCounts CleanImu(std::vector<StampedImu>& samples, const std::string& topic);

}  // namespace mlic
