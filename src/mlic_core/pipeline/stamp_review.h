#pragma once

#include <vector>

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// The tracks of each drive with their cameras' stamps as the courses have them.
std::vector<TrackSet> OnTime(const AdjustedCameras& cameras);

// Moves the stamps of cameras to their likeliest courses (LikeliestCourse), in steps, as the problem is not
// linear. True if any have moved by what still counts; then the state has been solved for anew. If not, they
// are settled (JointRounds).
bool ReviewStamps(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment);

}  // namespace mlic
