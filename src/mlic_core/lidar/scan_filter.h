#pragma once

#include "mlic_core/sensors/measurements.h"

namespace mlic {

// What was left out of a scan, and why; added up over a recording by operator+=.
struct ScanFilterCounts {
  std::size_t kept = 0;
  std::size_t not_finite = 0;
  std::size_t too_near = 0;  // zero range or nearer than the sensor can measure
  std::size_t too_far = 0;
  std::size_t duplicates = 0;  // thinned out: the voxel had a point already

  ScanFilterCounts& operator+=(const ScanFilterCounts& other);
};

// Sorts the points by time, drops non-finite and out-of-range ones and keeps the first of each 0.2 m voxel
// (never an average, which would bias the noise and the time). Bounds the memory of a recording: 5,000 to
// 10,000 points stay of a scan of 60,000.
ScanFilterCounts FilterScan(LidarScan& scan);

}  // namespace mlic
