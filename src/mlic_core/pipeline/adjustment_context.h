#pragma once

#include <string>

#include "mlic_core/pipeline/adjustment_steps.h"
#include "mlic_core/pipeline/stage_clock.h"

namespace mlic {

// Of an adjustment in a stage, whose progress and lines it passes on.
inline AdjustmentContext ContextOf(const StageContext& context, StageClock* stage) {
  return {context.rig,
          context.dataset,
          context.observer,
          {context.cancellation, [stage](double fraction) { stage->Progress(fraction); },
           [stage](const std::string& text) { stage->Line(text); }},
          context.options.matcher.get()};
}

}  // namespace mlic
