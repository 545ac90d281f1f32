#pragma once

#include <filesystem>

#include "mlic_core/calibration/result.h"

namespace mlic {

// Writes calibration.yaml, report.html, trajectory.tum (trajectory_2.tum and so on for further drives),
// map.pcd, static_transforms.launch and sensors.urdf.xacro, each whole or not at all. A refused result gets
// neither launch file nor URDF; files of an earlier run that this one does not write are removed.
// calibration.yaml is written last: where it stands, the others do.
void WriteResults(const std::filesystem::path& directory, const CalibrationResult& result);

}  // namespace mlic
