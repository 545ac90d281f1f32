#pragma once

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// What the adjustment found, judged (docs/method.md, section 12): trusted when the data show every LiDAR's
// rotation and time offset, and what they do not show of the translations has a guess.
void AssembleResult(const Rig& rig, const Dataset& dataset, const Adjustment& adjustment,
                    CalibrationResult* result);

// Of all sensors of the rig that have one.
std::vector<GuessedPose> GuessesOf(const Rig& rig);

// A refusal before there is a state: only the reasons.
void FinishRefused(CalibrationResult* result);

}  // namespace mlic
