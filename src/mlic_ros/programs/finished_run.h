#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "mlic_ros/programs/job.h"

namespace mlic {

// What an earlier run of the same inputs left in DIR/stages/finished.txt, so that the same call again returns
// at once. The same inputs: content of the rig file, path, size, modification time and samples of the content
// of each bag, start and duration, and the program itself.

// A name for all inputs of the job. Throws InputError for a file that cannot be read.
std::string InputKey(const JobOptions& options);

// The outcome of the earlier run; nothing when there was none, its inputs were others, or a result file was
// changed or removed since.
std::optional<JobOutcome> FindFinishedRun(const std::filesystem::path& directory, const std::string& key);

// Notes the run and the result files that lie in the directory now.
void NoteFinishedRun(const std::filesystem::path& directory, const std::string& key,
                     const JobOutcome& outcome);

}  // namespace mlic
