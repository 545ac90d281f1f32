#pragma once

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// Solves once more for each camera of double_sphere whose intrinsics all move, from the other intrinsics that
// project alike (DoubleSphereTwin), and takes those that cost less. True if any have changed.
bool ReviewLenses(const AdjustmentContext& context, Adjustment* adjustment);

}  // namespace mlic
