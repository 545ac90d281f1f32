#pragma once

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// Moves the stamps of cameras to their likeliest courses (LikeliestCourse), in steps, as the problem is not
// linear. True if any have moved by what still counts; then the state has been solved for anew. If not, they
// are settled (JointRounds).
bool ReviewStamps(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment);

}  // namespace mlic
