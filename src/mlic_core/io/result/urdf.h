#pragma once

#include <filesystem>

#include "mlic_core/result/result.h"

namespace mlic {

// Writes sensors.urdf.xacro: a link for the IMU (or CalibrationResult::root) and one for each sensor, fixed
// joints between them. It holds no macro, so xacro, check_urdf and robot_state_publisher all take it as it
// is; a vehicle's own xacro includes it and adds the joint from its base to it.
void WriteUrdf(const std::filesystem::path& path, const CalibrationResult& result);

}  // namespace mlic
