#pragma once

#include <filesystem>

#include "mlic_core/result/result.h"

namespace mlic {

// Writes calibration.yaml, format mlic_calibration/1 (file_format.h). In the file sigmas of rotations are in
// degrees, everything else in metres, seconds and radians; quaternions are x y z w.
void WriteCalibrationFile(const std::filesystem::path& path, const CalibrationResult& result);

// Reads such a file, a truth file too: absent keys keep their defaults, a verdict that is absent counts as
// trusted, absent sigmas are zero. Only `format`, `sensors` and each sensor's type and T_imu_sensor must be
// there. Of rejected sensors
// only type and reason are read. Throws InputError with file, line and key.
CalibrationResult ReadCalibrationFile(const std::filesystem::path& path);

}  // namespace mlic
