#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// Height, roll and pitch of the IMU over the ground; empty where the map does not show it.
std::string GroundTable(const CalibrationResult& result);

}  // namespace mlic
