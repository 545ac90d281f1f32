#include "mlic_core/lidar/scan_joining.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mlic_core/lidar/scan_filter.h"

namespace mlic {

std::size_t PiecesOfScan(double period) {
  constexpr double kUsual = 0.1;  // s, of a scan; from: standard, spinning LiDARs turn at 10 Hz
  return period > 0.0 ? std::max<std::size_t>(1, std::llround(kUsual / period)) : 1;
}

std::size_t JoinShortScans(LidarRecording* recording) {
  const std::size_t pieces = PiecesOfScan(recording->scan_period);
  if (pieces < 2) return 1;
  const double length = static_cast<double>(pieces) * recording->scan_period;
  std::vector<LidarScan> joined;
  for (LidarScan& piece : recording->scans) {
    if (joined.empty() || piece.time > joined.back().time + length - 0.5 * recording->scan_period) {
      joined.push_back(std::move(piece));
      continue;
    }
    LidarScan& scan = joined.back();
    const float later = static_cast<float>(piece.time - scan.time);
    for (LidarPoint& point : piece.points) {
      point.time += later;
      scan.points.push_back(point);
    }
  }
  for (LidarScan& scan : joined) {
    FilterScan(scan);
    scan.points.shrink_to_fit();
  }
  recording->scans = std::move(joined);
  recording->scan_period = length;
  return pieces;
}

}  // namespace mlic
