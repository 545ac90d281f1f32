#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mlic_core/pipeline/options.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_ros/bag/bag_loader.h"
#include "mlic_ros/programs/job_end.h"

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

// A display of the job: besides what the calibration shows, the rig once its frames are known, and the
// result, or in one line why there is none.
class JobObserver : public CalibrationObserver {
 public:
  virtual void OnRig(const Rig& /*rig*/) {}
  virtual void OnResult(const CalibrationResult& /*result*/) {}
  virtual void OnFailure(const std::string& /*line*/) {}
};

// The whole work of `calibrate`: rig file and bags in, files in the output directory out. Result files appear
// together at the end, or not at all. The log goes to output/log.txt and stderr. Where a run of the same
// inputs has left its results, they stay, and of the work nothing is shown. Bad input that shows before the
// work (options, output directory, rig file, bags that cannot be read) leaves nothing, not even a log. Throws
// nothing: an exception of a part, or of make_options, is an end too.
JobEnd RunCalibrationJob(const std::function<JobOptions()>& make_options,
                         const CancellationToken& cancellation, JobObserver& display);

}  // namespace mlic
