#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// What would make the calibration better, or possible, one sentence each: from the verdict, the unobservable
// directions and the residuals. Not empty of a refused one.
std::vector<std::string> Advice(const CalibrationResult& result);

// The command that publishes the transforms of the results in that directory, from any folder.
std::string UseCommand(const std::filesystem::path& place);

// The commands that use the results and watch over them, with the real paths, then the advice; of a refused
// one the advice alone. place: the directory in which the results lie.
std::string NextStep(const CalibrationResult& result, const std::filesystem::path& place);

}  // namespace mlic
