#pragma once

#include <filesystem>
#include <string>

#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"

namespace mlic {

// The state between two solves as a result that is refused because it is not one: for looking at it while the
// calibration goes on.
CalibrationResult UnfinishedResult(const CalibrationSnapshot& snapshot, const std::string& imu_frame);

// calibration.yaml, trajectory.tum and map.pcd: no file that others would load.
void WriteUnfinished(const std::filesystem::path& directory, const CalibrationResult& result);

}  // namespace mlic
