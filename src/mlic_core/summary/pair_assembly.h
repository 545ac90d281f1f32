#pragma once

#include "mlic_core/initialization/lidars_alone.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// rig: that of the whole. alone, adjustment: its LiDARs, adjusted without the IMU. Makes a refused result one
// of pairs: partial, where they can be trusted (docs/method.md, section 12); else it stays refused, without
// pairs.
void AssemblePairs(const Rig& rig, const LidarsAlone& alone, const Adjustment& adjustment,
                   CalibrationResult* result);

}  // namespace mlic
