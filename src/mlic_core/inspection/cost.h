#pragma once

#include <cstddef>

#include "mlic_core/inspection/finding.h"

namespace mlic {

// What a calibration is expected to take.
struct Cost {
  double processor_seconds = 0.0;
  double memory = 0.0;  // GB, the peak
};

// What a rig's sensors send, as far as it makes the cost.
struct SensorLoad {
  double scans = 0.0;  // of all LiDARs together, as they are joined (lidar/scan_joining.h), 1/s
  std::size_t cameras = 0;
};

// Of a drive of that many seconds.
Cost ExpectedCost(const SensorLoad& load, double seconds);

// The longest drive, s, that a calibration takes as a whole: within 4 GB of memory, 6 GB with cameras, and
// half an hour of one core; never less than a minute. Of longer ones it takes a part.
double LongestDrive(const SensorLoad& load);

// Beside what the machine has: GB of memory free, threads.
Findings CostFindings(const Cost& cost, double free_memory, std::size_t threads);

}  // namespace mlic
