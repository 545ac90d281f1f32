#pragma once

#include <functional>

#include "mlic_core/common/progress.h"
#include "mlic_ros/display/job_observer.h"
#include "mlic_ros/programs/job.h"
#include "mlic_ros/programs/job_end.h"

namespace mlic {

// The whole work of `calibrate`: rig file and bags in, files in the output directory out. Result files appear
// together at the end, or not at all. The log goes to output/log.txt and stderr. Where a run of the same
// inputs has left its results, they stay, and of the work nothing is shown. Bad input that shows before the
// work (options, output directory, rig file, bags that cannot be read) leaves nothing, not even a log. Throws
// nothing: an exception of a part, or of make_options, is an end too.
JobEnd RunCalibrationJob(const std::function<JobOptions()>& make_options,
                         const CancellationToken& cancellation, JobObserver& display);

}  // namespace mlic
