#pragma once

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// Solves once more for each camera of double_sphere whose intrinsics all move, from the other intrinsics that
// project alike (DoubleSphereTwin), and takes those that cost less. True if any have changed.
// probe_matrices: as in the round, of whose solve these take the place.
bool ReviewLenses(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment);

}  // namespace mlic
