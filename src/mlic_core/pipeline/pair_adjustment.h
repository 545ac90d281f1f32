#pragma once

#include "mlic_core/initialization/lidars_alone.h"
#include "mlic_core/pipeline/adjustment_steps.h"

namespace mlic {

// docs/method.md, section 8, of LiDARs without the IMU: the joint rounds about the root, and their
// uncertainty. after_round: as JointOptions has it. adjustment: where StartPairAdjustment or an earlier run's
// last round has left it.
Adjustment AdjustPairs(Adjustment adjustment, const AdjustmentContext& context,
                       const std::function<void(const Adjustment&)>& after_round);

// The LiDARs that are tied, about the root. alone must outlive it.
Adjustment StartPairAdjustment(const LidarsAlone& alone);

}  // namespace mlic
