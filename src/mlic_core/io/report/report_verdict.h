#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// The verdict in plain words, with reasons, warnings and the least certain numbers; a piece of HTML.
std::string VerdictBlock(const CalibrationResult& result);

// What to do next, one sentence each, from the verdict, the unobservable directions and the residuals. place:
// the directory in which the results lie.
std::vector<std::string> NextSteps(const CalibrationResult& result, const std::filesystem::path& place);

// The largest sigma of each kind among the directions that the data show: rad, m, s. Of pairs where they
// stand about a root.
struct LargestSigmas {
  double rotation = 0.0;
  double translation = 0.0;
  double time_offset = 0.0;
};
LargestSigmas FindLargestSigmas(const CalibrationResult& result);

// The command that publishes the transforms of the results in that directory, from any folder.
std::string UseCommand(const std::filesystem::path& place);

}  // namespace mlic
