#pragma once

#include <filesystem>
#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// Writes report.html: one file that opens offline, figures inside. First the verdict in plain words, then
// what was found with its uncertainty, the figures, the time of each stage, and what to do next. place: the
// directory in which the results will lie, which the advice names.
void WriteReport(const std::filesystem::path& path, const CalibrationResult& result,
                 const std::filesystem::path& place);

}  // namespace mlic
