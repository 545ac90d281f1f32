#pragma once

#include <vector>

#include "mlic_core/io/result/exported_file.h"
#include "mlic_core/result/result.h"

namespace mlic {

// Parts of the configurations of LiDAR-inertial odometries that a calibration decides: a file for each LiDAR,
// NAME.yaml, of FAST-LIVO2 for each LiDAR with each camera, LIDAR_CAMERA.yaml, and camera_NAME.yaml. Numbers
// as rosparam reads them. Empty where there is no such sensor.
std::vector<ExportedFile> FastLioFiles(const CalibrationResult& result);
std::vector<ExportedFile> LioSamFiles(const CalibrationResult& result);
std::vector<ExportedFile> FastLivo2Files(const CalibrationResult& result);

}  // namespace mlic
