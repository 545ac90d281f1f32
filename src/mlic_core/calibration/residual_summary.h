#pragma once

#include <vector>

#include "mlic_core/calibration/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

class Refinement;

// Residual statistics of every LiDAR and of the IMU at the refinement's state, first drive.
std::vector<ResidualSummary> SummarizeResiduals(const Rig& rig, const Dataset& dataset,
                                                const Refinement& refinement);

}  // namespace mlic
