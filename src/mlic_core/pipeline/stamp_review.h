#pragma once

#include <vector>

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// The tracks of each drive with their cameras' stamps as the courses have them.
std::vector<TrackSet> OnTime(const AdjustedCameras& cameras);

// Moves the stamps of cameras to where their images' own time errors show a course (FindStampCourse), in
// steps: the trajectory has followed a part of it. True if any have moved by what still counts; then the
// state has been solved for anew.
bool ReviewStamps(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment);

}  // namespace mlic
