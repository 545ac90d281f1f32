#pragma once

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// What sensors err by beside the calibration, in the order in which it is looked for.
enum class SensorError { kNone, kLens, kClock, kStamps, kImuMatrices, kBiases, kRanges };

// The first that the data show and that is not followed yet, at a calibration that has settled: the next ones
// are looked for once it has settled with that. The state then has been solved for anew, or is by the next
// round. probe_matrices: as in the round.
SensorError FindSensorError(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment);

}  // namespace mlic
