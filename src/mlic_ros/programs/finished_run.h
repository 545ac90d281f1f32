#pragma once

#include <string>

#include "mlic_core/io/output_directory.h"
#include "mlic_ros/programs/job.h"

namespace mlic {

// What an earlier run of the same inputs noted in DIR/stages/finished.txt, so that the same call again
// returns at once. The same inputs: content of the rig file, path, size, modification time and samples of the
// content of each bag, start and duration, and the program itself.

// A name for all inputs of the job. Throws InputError for a file that cannot be read.
std::string InputKey(const JobOptions& options);

// The results that stand there are those of a run of these inputs, none changed or removed since.
bool IsFinished(const OutputDirectory& output, const std::string& key);

// Notes that the results that stand there now are of these inputs.
void NoteFinishedRun(const OutputDirectory& output, const std::string& key);

}  // namespace mlic
