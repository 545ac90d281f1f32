#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// The verdict in plain words, with reasons, warnings and the least certain numbers; a piece of HTML.
std::string VerdictBlock(const CalibrationResult& result);

// What to do next, one sentence each, from the verdict, the unobservable directions and the residuals.
std::vector<std::string> NextSteps(const CalibrationResult& result);

}  // namespace mlic
