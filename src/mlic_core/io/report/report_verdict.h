#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// The verdict in plain words, with reasons and the least certain numbers; a piece of HTML.
std::string VerdictBlock(const CalibrationResult& result);

// The largest sigma of each kind among the directions that the data show: rad, m, s. Of pairs where they
// stand about a root.
struct LargestSigmas {
  double rotation = 0.0;
  double translation = 0.0;
  double time_offset = 0.0;
};
LargestSigmas FindLargestSigmas(const CalibrationResult& result);

}  // namespace mlic
