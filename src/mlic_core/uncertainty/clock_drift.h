#pragma once

#include "mlic_core/problem/state.h"
#include "mlic_core/uncertainty/observability.h"

namespace mlic {

// Whether the data show that the clock of some sensor drifts beside the others' and the IMU's, by more than
// three sigmas with all these in step. What sensors drift against each other can be known far better than
// what all of them drift against the IMU. analysis: of the state, whose drifts are those that are estimated.
bool ClocksDrift(const CalibrationState& state, bool estimate_imu_matrices,
                 const ObservabilityAnalysis& analysis);

}  // namespace mlic
