#pragma once

#include <filesystem>
#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// Intrinsics of one camera in the format of ROS' camera_info_manager (camera_calibration_parsers). Empty for
// double_sphere: sensor_msgs/CameraInfo has no name for that model, and no driver could load it.
std::string CameraInfoText(const SensorResult& camera);

// Writes NAME.yaml into the directory for each camera that has such a text; makes the directory if there is
// one.
void WriteCameraInfos(const std::filesystem::path& directory, const CalibrationResult& result);

}  // namespace mlic
