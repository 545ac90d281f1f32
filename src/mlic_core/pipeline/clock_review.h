#pragma once

#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// The clocks that a solve may probe: that do not drift, are not held and were not judged to be constant.
std::vector<SensorId> ConstantClocks(const Adjustment& adjustment);

// Decides whether the sensors' clocks drift in the next round, all of them or none (docs/method.md, section
// 8.1): they do where one's drift beside the others exceeds 3 of its sigmas, which for a clock that keeps
// step happens in 3 of 1000 drives. A first look, at the clocks that the last solve probed, with sigmas that
// are too small, keeps most rigs' clocks constant; what remains is solved for, and its sigma grown by all
// that the result's grow by. Clocks that then turn out to be constant stay so. True if other clocks drift
// than before; then the state has been solved for anew.
bool ReviewClocks(const AdjustmentContext& context, Adjustment* adjustment);

}  // namespace mlic
