#pragma once

#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What was left out of a scan, and why; added up over a recording by operator+=.
struct ScanFilterCounts {
  std::size_t kept = 0;
  std::size_t not_finite = 0;
  std::size_t too_near = 0;  // zero range or nearer than LiDARs measure
  std::size_t too_far = 0;
  std::size_t duplicates = 0;  // thinned out: the voxel had a point already

  ScanFilterCounts& operator+=(const ScanFilterCounts& other);
};

// Sorts the points by time, drops non-finite and out-of-range ones (0.3 to 300 m stay) and keeps the earliest
// of each voxel (never an average, which would bias the noise and the time). The voxels are 0.2 m wide, and
// 0.1 or 0.05 m in scans of which fewer than 5,000 points would stay. Bounds the memory of a recording: of a
// scan of 25,000 points about 10,000 stay, of 60,000 about 25,000. The order of the points in the message
// does not matter, but among points of the same time.
ScanFilterCounts FilterScan(LidarScan& scan);

}  // namespace mlic
