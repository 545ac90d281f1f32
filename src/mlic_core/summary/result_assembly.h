#pragma once

#include <cstddef>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

class Refinement;

std::size_t ImuSampleCount(const Dataset& dataset);

// What the refinement found, judged (SPEC section 5): trusted when the data show every LiDAR's rotation and
// time offset, and what they do not show of the translations has a guess.
void AssembleResult(const Rig& rig, const Dataset& dataset, const Refinement& refinement,
                    CalibrationResult* result);

// A refusal before there is a state: only the reasons.
void FinishRefused(CalibrationResult* result);

}  // namespace mlic
