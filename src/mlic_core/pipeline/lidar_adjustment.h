#pragma once

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// Each LiDAR on planes of its own. The base LiDAR's refines the trajectory, the others' leave it. One whose
// planes do not hold it, so that it turns out of the base LiDAR's map, stays where it was.
Adjustment AdjustEachLidar(Adjustment adjustment, const AdjustmentContext& context);

// After AdjustEachLidar: LiDARs that were not aligned and whose planes lead far from their guess
// (guess_check.h) take no further part.
void RejectLostLidars(const AdjustmentContext& context, Adjustment* adjustment);

}  // namespace mlic
