#pragma once

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// Solves once more for each camera of double_sphere whose intrinsics all move, from the other intrinsics that
// project alike (DoubleSphereTwin), and takes those that cost less. True if any have changed.
// probes: of the round, which the solves that take the place of its own carry too.
bool ReviewLenses(const AdjustmentContext& context, const Probes& probes, Adjustment* adjustment);

}  // namespace mlic
