#pragma once

#include <optional>
#include <vector>

#include "mlic_core/sensors/measurements.h"

namespace mlic {

struct AzimuthRate {
  double radians_per_second = 0.0;  // with sign
  double sweep = 0.0;               // s, from the ring's first point to its last
};

// How fast the azimuth of the fullest ring advances: a line through azimuth over time. Nothing where the
// points have no rings or times, or the ring is no steady revolution of 300 degrees or more.
std::optional<AzimuthRate> MeasureAzimuthRate(const std::vector<LidarPoint>& points);

}  // namespace mlic
