#pragma once

#include <filesystem>

#include "mlic_core/result/result.h"

namespace mlic {

// Writes a launch file that publishes every sensor's pose in the frame of the IMU or of
// CalibrationResult::root, one tf2_ros
// static_transform_publisher each (x y z qx qy qz qw parent child; roslaunch splits them as a
// shell does). roslaunch runs it as it is.
void WriteStaticTransforms(const std::filesystem::path& path, const CalibrationResult& result);

}  // namespace mlic
