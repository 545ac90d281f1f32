#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/evaluation/harp.h"
#include "mlic_core/result/result.h"

namespace mlic {

// `evaluate --harp`: photos of straight bars or strings by one camera, and how straight its intrinsics make
// them.
struct HarpEvaluation {
  std::string camera;
  std::vector<HarpColumn> columns;  // of the calibration, and of the truth where there is one
  cv::Mat picture;                  // the photo whose edges are off most
};

// folder: holds the photos (png, jpg, bmp, tif), all of the camera's image size; camera: its name in the
// calibration, empty where that has one alone. InputError names the photo, or the cameras that there are.
HarpEvaluation MeasurePhotos(const std::filesystem::path& folder, const std::string& camera,
                             const CalibrationResult& calibration,
                             const std::optional<CalibrationResult>& truth);

}  // namespace mlic
