#include "mlic_core/inspection/cost.h"

#include <algorithm>

#include "mlic_core/camera/tracks/keyframes.h"
#include "mlic_core/ingest/drive_notes.h"

namespace mlic {
namespace {

// Lines through docs/benchmark.md, "Long recordings": four LiDARs at 10 Hz over 60 s and one over 120 s;
// cameras: the paper's six over 60 s beside its LiDARs alone.
constexpr double kSecondsOfScan = 0.13;     // from: measured, as above, within 25 percent
constexpr double kSecondsOfKeyframe = 1.1;  // from: measured, as above: 80 keyframes of each camera
constexpr double kLeastMemory = 0.3;        // GB; from: measured, as above
constexpr double kMemoryOfScan = 0.41e-3;   // GB; from: measured, as above
constexpr double kMemoryOfSecond = 5.1e-3;  // GB, of control points that planes tie; from: measured, as above
constexpr double kMemoryOfKeyframe = 3e-3;  // GB; from: measured, as above; 1.5e-3 of a stereo camera
constexpr double kMostOfMemory = 0.7;       // of what is free; from: definition
// Of a drive that is calibrated as a whole; from: definition, a machine of 16 GB has room for two.
constexpr double kMostMemory = 4.0, kMoreWithCameras = 2.0;  // GB
constexpr double kMostWork = 1800.0;                         // s of one core; from: definition
constexpr double kLeastPart = 60.0;  // s; from: definition, of other costs the cause is the rig

}  // namespace

Cost ExpectedCost(const SensorLoad& load, double seconds) {
  const bool lidars = load.scans > 0.0;
  const double scans = load.scans * seconds;
  const double keyframes = static_cast<double>(load.cameras) * MostKeyframes(seconds, lidars);
  return {kSecondsOfScan * scans + kSecondsOfKeyframe * keyframes,
          kLeastMemory + (lidars ? kMemoryOfSecond * seconds : 0.0) + kMemoryOfScan * scans +
              kMemoryOfKeyframe * keyframes};
}

double LongestDrive(const SensorLoad& load) {
  const double most_memory = kMostMemory + (load.cameras > 0 ? kMoreWithCameras : 0.0);
  // Beyond a minute both grow in proportion.
  const Cost cost = ExpectedCost(load, kLeastPart);
  const double by_memory = (most_memory - kLeastMemory) / (cost.memory - kLeastMemory);
  const double by_work = kMostWork / cost.processor_seconds;
  return kLeastPart * std::max(1.0, std::min(by_memory, by_work));
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
