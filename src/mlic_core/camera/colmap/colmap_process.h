#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"

namespace mlic {

// How a program that was run ended.
struct ProcessEnd {
  bool found = true;      // false: there is no such program
  int status = 0;         // its exit status; 128 + number where a signal ended it
  std::string last_line;  // the last line of its output that is not empty
  bool Good() const { return found && status == 0; }
};

// Runs a program (found by PATH) with its output in log_file (appended), on a single processor so that its
// results do not depend on how many there are. Kills it and throws Cancelled when the token is set.
// meanwhile: called about twice a second while it runs.
ProcessEnd RunProcess(const std::vector<std::string>& command, const std::filesystem::path& log_file,
                      const CancellationToken& cancellation, const std::function<void()>& meanwhile = {});

}  // namespace mlic
