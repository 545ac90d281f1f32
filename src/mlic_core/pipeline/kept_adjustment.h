#pragma once

#include <string>

#include "mlic_core/pipeline/stage_clock.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// What an earlier run kept of the stage, or the adjustment as it is.
inline Adjustment TakeOver(const StageContext& context, const std::string& name, const Adjustment& adjustment,
                           bool* found) {
  Adjustment kept = adjustment;
  *found = context.Load(name, &kept);
  return *found ? kept : adjustment;
}

// For the run that takes it over, with what the stage has said so far.
inline void Keep(const StageContext& context, const StageClock& stage, const std::string& name,
                 Adjustment adjustment) {
  adjustment.lines = stage.lines();
  context.Save(name, adjustment);
}

}  // namespace mlic
