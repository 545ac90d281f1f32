#pragma once

#include <string>

#include "mlic_core/common/progress.h"
#include "mlic_ros/display/job_observer.h"
#include "mlic_ros/programs/job.h"

namespace mlic {

// The whole work of `calibrate`: rig file and bags in, files in the output directory out. Result files appear
// together at the end, or not at all. The log goes to output/log.txt and stderr. Throws what its parts throw
// (InputError, Cancelled, ...), after writing it to the log. Where a run of the same inputs has left its
// results, they stay and nothing is shown.
JobOutcome RunCalibrationJob(const JobOptions& options, const CancellationToken& cancellation,
                             JobObserver& display);

// ", see DIR/log.txt" and the like, for RunProgram.
std::string LogHint(const JobOptions& options);

}  // namespace mlic
