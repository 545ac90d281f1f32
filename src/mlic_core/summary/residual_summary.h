#pragma once

#include <vector>

#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// Reprojection errors of every camera that sees landmarks of the first drive, both coordinates of each
// together, each divided by its own sigma; `sigma` is their root mean square.
std::vector<ResidualSummary> SummarizeCameraResiduals(const Rig& rig, const CalibrationState& state,
                                                      const LandmarkSet& landmarks);

// Residual statistics of every LiDAR, every camera and the IMU at the adjustment's state, first drive.
std::vector<ResidualSummary> SummarizeResiduals(const Rig& rig, const Dataset& dataset,
                                                const Adjustment& adjustment);

}  // namespace mlic
