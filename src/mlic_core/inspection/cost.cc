#include "mlic_core/inspection/cost.h"

#include <algorithm>

#include "mlic_core/ingest/drive_notes.h"

namespace mlic {
namespace {

// Lines through docs/benchmark.md: one to four LiDARs over 15 to 120 s of driving (300 to 4800 scans: 14 to
// 208 s, 0.42 to 2.5 GB), and the paper's rig with its six cameras over 60 s (10.5 min and 2.9 GB; LiDARs
// alone 99 s and 1.45 GB).
constexpr double kSecondsOfScan = 0.05;    // from: measured, as above, within 25 percent
constexpr double kSecondsOfCamera = 90.0;  // from: measured, as above; keyframes do not grow with the length
constexpr double kLeastMemory = 0.3;       // GB; from: measured, as above
constexpr double kMemoryOfScan = 0.45e-3;  // GB; from: measured, as above, within 25 percent
constexpr double kMemoryOfCamera = 0.25;   // GB; from: measured, as above
constexpr double kMostOfMemory = 0.7;      // of what is free; from: definition

}  // namespace

Cost ExpectedCost(std::size_t scans, std::size_t cameras) {
  const double n = static_cast<double>(scans), c = static_cast<double>(cameras);
  return {kSecondsOfScan * n + kSecondsOfCamera * c, kLeastMemory + kMemoryOfScan * n + kMemoryOfCamera * c};
}

Findings CostFindings(const Cost& cost, double free_memory, std::size_t threads) {
  const double share = free_memory > 0.0 ? cost.memory / free_memory : 0.0;
  const Grade grade = share > 1.0 ? Grade::kFail : share > kMostOfMemory ? Grade::kWarn : Grade::kPass;
  const double seconds = cost.processor_seconds / static_cast<double>(std::max<std::size_t>(1, threads));
  return {{grade, "machine", "expected cost of the calibration",
           "about " + Number(cost.memory, "%.1f") + " GB of " + Number(free_memory, "%.1f") + " GB free, " +
               Number(cost.processor_seconds / 60.0, "%.1f") + " processor minutes, " +
               Number(seconds / 60.0, "%.1f") + " or more on " + std::to_string(threads) + " cores",
           "70 % of the free memory", "use --duration for a shorter part, or fewer sensors, or more memory"}};
}

}  // namespace mlic
