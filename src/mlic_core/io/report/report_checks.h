#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// What a check measures, in one line for people; empty for a name that is none.
std::string MeaningOf(const std::string& check);

// The warnings, and what the verdict rests on: of each kind of check those that failed, or the sensor nearest
// to the limit, with value, limit, meaning and remedy; all of them folded below. Empty without either.
std::string ChecksTable(const CalibrationResult& result);

}  // namespace mlic
