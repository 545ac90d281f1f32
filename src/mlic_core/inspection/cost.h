#pragma once

#include <cstddef>

#include "mlic_core/inspection/finding.h"

namespace mlic {

// What a calibration is expected to take.
struct Cost {
  double processor_seconds = 0.0;
  double memory = 0.0;  // GB, the peak
};

Cost ExpectedCost(std::size_t scans, std::size_t cameras);

// Beside what the machine has: GB of memory free, threads.
Findings CostFindings(const Cost& cost, double free_memory, std::size_t threads);

}  // namespace mlic
