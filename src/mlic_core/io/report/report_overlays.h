#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// Of each camera that was matched to the map, its photo with the LiDAR points by depth: with the sensors at
// the rig file's guess (where there is none, as before the match) and as found, and a slider between the two.
// Empty without such cameras.
std::string Overlays(const CalibrationResult& result);

}  // namespace mlic
