#pragma once

#include <string>

#include "mlic_core/io/result/sensor_tree.h"

namespace mlic {

// The poses as Autoware's sensor_kit_calibration.yaml and sensors_calibration.yaml have them: PARENT: {FRAME:
// {x, y, z, roll, pitch, yaw}}.
std::string AutowareText(const SensorTree& tree);

}  // namespace mlic
