#pragma once

#include <vector>

#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// Of each camera that found places of the LiDAR map the photo with most of them (first drive), with what the
// LiDARs saw about that time: projected by the cameras `before` the photos were matched, by those of the
// state, and with the poses that the rig file guesses. landmarks: of the first drive, as solved. LiDARs that
// were rejected are left out.
std::vector<CameraProjection> ProjectOnPhotos(const Rig& rig, const Dataset& dataset,
                                              const std::vector<CameraCalibration>& before,
                                              const CalibrationState& state, const LandmarkSet& landmarks,
                                              const std::vector<bool>& rejected_lidars);

}  // namespace mlic
