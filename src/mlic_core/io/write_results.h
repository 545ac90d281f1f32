#pragma once

#include <filesystem>

#include "mlic_core/result/result.h"

namespace mlic {

// Writes calibration.yaml, report.html, trajectory.tum (trajectory_2.tum and so on for further drives),
// map.pcd, static_transforms.launch, sensors.urdf.xacro, sensors_macro.xacro, and where there are cameras
// camera_info/NAME.yaml, kalibr_camchain.yaml, images/NAME_tracks.png and images/keyframes.csv, each whole or
// not at all; initial_calibration.yaml holds the sensors as they stood before the joint adjustment. A refused
// result gets none that others would load: neither launch file nor URDF nor camera files. The directory is a
// new one, see OutputDirectory; place is where its files will lie in the end, which the report names.
void WriteResults(const std::filesystem::path& directory, const CalibrationResult& result,
                  const std::filesystem::path& place);

}  // namespace mlic
