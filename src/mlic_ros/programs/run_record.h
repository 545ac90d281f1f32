#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/run_record.h"
#include "mlic_ros/programs/job.h"

namespace mlic {

// What calibration.yaml says of how it was made: files with the hashes of their content (rig, prior, masks,
// bags), and the command. Throws InputError for a file that cannot be read.
RunRecord RecordRun(const JobOptions& options);

// The recordings of this run that an earlier one was made of, too, by their content.
std::vector<std::string> SharedInputs(const RunRecord& run, const RunRecord& earlier,
                                      const std::vector<std::filesystem::path>& bags);

}  // namespace mlic
