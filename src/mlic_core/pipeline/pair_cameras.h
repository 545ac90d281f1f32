#pragma once

#include <vector>

#include "mlic_core/initialization/lidars_alone.h"
#include "mlic_core/pipeline/stage_clock.h"
#include "mlic_core/sensors/sensor_problem.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// What the LiDARs' maps show of cameras where nothing ties them to the IMU.
struct PairedCameras {
  std::vector<PairResult> pairs;        // with at least one camera; none that is hardly known
  std::vector<SensorProblem> problems;  // of cameras that are in no pair
  std::vector<CameraProjection> projections;
};

// docs/method.md, section 7.7: places the cameras in the map; then, unless the vehicle is parked, the joint
// adjustment about the root with their tracks and their matches with the map. whole: the calibration with the
// IMU that was refused, whose matches with the map place cameras as well; null: there is none. known: pairs
// that it shows already, whose cameras are left out. lidars: as adjusted; a copy goes on, so that no camera
// moves the pairs of LiDARs. alone: loses the cameras that are known or have no place, and the scans of
// LiDARs that are not tied.
PairedCameras PairCameras(const StageContext& context, const Adjustment* whole,
                          const std::vector<PairResult>& known, Adjustment lidars, LidarsAlone* alone);

}  // namespace mlic
