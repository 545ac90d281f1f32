#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"

namespace mlic {

// One call of a program, and how it ended.
struct DriveRun {
  std::vector<std::string> command;  // program and arguments
  std::filesystem::path log;         // what it prints
  int status = -1;                   // exit status; 128 and more: by a signal; negative: not ended
};

// Runs them as processes of this machine, so many at a time, and sets their statuses; on_end is called with
// the index of each that has ended. Once cancelled, those that run are interrupted and waited for, no other
// is begun, and Cancelled is thrown. InputError where the program cannot be started.
void RunHere(std::size_t at_once, const CancellationToken& cancellation,
             const std::function<void(std::size_t)>& on_end, std::vector<DriveRun>* runs);

// Runs them as one array job of Slurm and waits for its end: directory/slurm.sh is what is submitted, and
// each run's status comes by a file beside its log; of one that Slurm ended it stays
// negative. threads: of
// each; 0: as many as Slurm gives. Once cancelled, the job is, and Cancelled is thrown. InputError where
// sbatch is missing or refuses.
void RunOnSlurm(const std::filesystem::path& directory, int threads, const CancellationToken& cancellation,
                const std::function<void(std::size_t)>& on_end, std::vector<DriveRun>* runs);

}  // namespace mlic
