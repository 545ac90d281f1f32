#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// The first drive from above: points coloured by LiDAR, the path, start and end, a scale; empty without a
// trajectory and a map.
std::string TopViewFigure(const CalibrationResult& result);

}  // namespace mlic
