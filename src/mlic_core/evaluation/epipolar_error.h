#pragma once

#include <string>
#include <vector>

#include "mlic_core/evaluation/fresh_matches.h"

namespace mlic {

// How far matches between two cameras are from their epipolar curves.
struct EpipolarStatistics {
  std::string a, b;
  std::size_t image_pairs = 0;
  std::size_t matches = 0;
  double median = 0.0;  // px, the mean of the distances in both images
  double mean = 0.0;    // px
};

// For every pair of cameras with matches, in their order. The relative pose of the two exposures, each row at
// its own time, comes from the trajectory (T_map_imu, in order of time), extrinsics, offsets and intrinsics
// from the calibration; matches of cameras that it lacks are left out. Distances to the epipolar curve are to
// first order in pixels, for any camera model.
std::vector<EpipolarStatistics> MeasureEpipolarErrors(const std::vector<FreshMatch>& matches,
                                                      const CalibrationResult& calibration,
                                                      const std::vector<StampedPose>& trajectory);

// The errors under one calibration.
struct EpipolarColumn {
  std::string name;  // "calibration", "truth", ...
  std::vector<EpipolarStatistics> errors;
};

// One line for each pair, with the errors under each calibration. For people.
std::string TableOf(const std::vector<EpipolarColumn>& columns);

// calibration,a,b,image_pairs,matches,median_px,mean_px
std::string CsvOf(const std::vector<EpipolarColumn>& columns);

}  // namespace mlic
