#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/pipeline/options.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_ros/bag/bag_loader.h"

namespace mlic {

struct JobOptions {
  std::filesystem::path rig;
  std::vector<std::filesystem::path> bags;
  std::filesystem::path output;  // directory
  LoadOptions load;
  CalibrationOptions calibration;
  int threads = 0;     // 0: one for each core; from: structural
  bool fresh = false;  // do the work even where a finished run of the same inputs left its results
};

// How the job ended, where it did not throw.
struct JobOutcome {
  bool trusted = false;
  std::string refusal;  // why it is refused and what to do: one line
};

// A display of the job: besides what the calibration shows, the rig once its frames are known, and the
// result.
class JobObserver : public CalibrationObserver {
 public:
  virtual void OnRig(const Rig& /*rig*/) {}
  virtual void OnResult(const CalibrationResult& /*result*/) {}
};

// The whole work of `calibrate`: rig file and bags in, files in the output directory out. Result files appear
// together at the end, or not at all. The log goes to output/log.txt and stderr. Throws what its parts throw
// (InputError, Cancelled, ...), after writing it to the log. Where a run of the same inputs has left its
// results, they stay and nothing is shown.
JobOutcome RunCalibrationJob(const JobOptions& options, const CancellationToken& cancellation,
                             JobObserver& display);

// ", see DIR/log.txt" and the like, for RunProgram.
std::string LogHint(const JobOptions& options);

}  // namespace mlic
