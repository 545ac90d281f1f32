#pragma once

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// Decides which sensors' clocks drift in the next round (docs/method.md, section 8.1): those whose drift
// exceeds 3 of its sigmas, which for a clock that keeps step happens in 3 of 1000 drives. A first look, one
// step of all drifts with sigmas that are too small, keeps most clocks constant at the cost of one
// linearisation; what remains is solved for, and its sigma grown by all that the result's grow by. A clock
// that then turns out to be constant stays so. True if other clocks drift than before; then the state has
// been solved for anew.
bool ReviewClocks(const AdjustmentContext& context, Adjustment* adjustment);

}  // namespace mlic
