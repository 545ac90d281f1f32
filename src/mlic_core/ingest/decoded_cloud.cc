#include "mlic_core/ingest/decoded_cloud.h"

#include <algorithm>
#include <cmath>

namespace mlic {

bool HasReturn(const Eigen::Vector3f& point) { return point.allFinite() && point.squaredNorm() > 1e-6f; }

std::optional<PointTimeRange> TimeRangeOf(const DecodedCloud& cloud, const PointTimeField& times) {
  std::optional<PointTimeRange> range;
  for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
    const double time = times.values[i];
    if (!HasReturn(cloud.positions[i]) || !std::isfinite(time)) continue;
    if (!range) range = PointTimeRange{cloud.stamp, time, time};
    range->minimum = std::min(range->minimum, time);
    range->maximum = std::max(range->maximum, time);
  }
  return range;
}

}  // namespace mlic
