#pragma once

#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What was left out of a scan, and why; added up over a recording by operator+=.
struct ScanFilterCounts {
  std::size_t kept = 0;
  std::size_t not_finite = 0;
  std::size_t too_near = 0;  // zero range or nearer than LiDARs measure
  std::size_t too_far = 0;
  std::size_t thinned_out = 0;

  ScanFilterCounts& operator+=(const ScanFilterCounts& other);
};

// Sorts the points by time, drops non-finite and out-of-range ones and keeps about 12,000, picked by their
// index. The choice must not depend on the measured ranges: the first point of each voxel, say, is one whose
// noise carried it across the border, which turned a calibration by 0.025 deg.
ScanFilterCounts FilterScan(LidarScan& scan);

}  // namespace mlic
