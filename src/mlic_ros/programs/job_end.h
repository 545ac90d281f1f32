#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// How a calibration ended: the exit status (see program.h), and the last three lines on the terminal: the
// verdict with the worst sigma or the reason; where report or log lie; what to do next.
struct JobEnd {
  int status = 0;
  std::array<std::string, 3> lines;
};

// The end with a result, which lies in the directory.
JobEnd EndWithResult(const CalibrationResult& result, const std::filesystem::path& directory);

// The end by the exception that is being handled. log: the run's log; empty where none was written.
JobEnd EndWithException(const std::filesystem::path& log);

// The lines on stderr, after everything else.
void PrintLastLines(const JobEnd& end);

// The lines as one text.
std::string LastLinesText(const JobEnd& end);

}  // namespace mlic
