#pragma once

#include <filesystem>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// Writes T_map_imu in TUM's format, one pose a line: seconds (IMU clock, all nine decimals), tx ty tz, qx qy
// qz qw.
void WriteTrajectoryFile(const std::filesystem::path& path, const std::vector<StampedPose>& trajectory);

// Reads such a file; lines that begin with # are comments. InputError names the line that does not fit.
std::vector<StampedPose> ReadTrajectoryFile(const std::filesystem::path& path);

}  // namespace mlic
