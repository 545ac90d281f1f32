#pragma once

#include <vector>

#include "mlic_core/io/result/exported_file.h"
#include "mlic_core/result/result.h"

namespace mlic {

// For VINS-Fusion: vins_fusion.yaml, the part of its configuration that a calibration decides (body_T_cam0,
// body_T_cam1, ... and td), and each camera's NAME.yaml: PINHOLE with k1 k2 p1 p2, or KANNALA_BRANDT. Cameras
// that neither holds are left out with a comment. Empty where no camera is left.
std::vector<ExportedFile> VinsFusionFiles(const CalibrationResult& result);

}  // namespace mlic
