#pragma once

#include <string>
#include <vector>

#include "mlic_core/calibration/joint_problem.h"
#include "mlic_core/calibration/observer.h"
#include "mlic_core/calibration/result.h"

namespace mlic {

class Refinement;

std::size_t ImuSampleCount(const Dataset& dataset);

// What the refinement found, judged (SPEC section 5): trusted when the data show every LiDAR's rotation and
// time offset, and what they do not show of the translations has a guess.
void AssembleResult(const Rig& rig, const Dataset& dataset, const Refinement& refinement,
                    CalibrationResult* result);

// A refusal before there is a state: only the reasons.
void FinishRefused(CalibrationResult* result);

// The state as observers see it: the first drive's map (thinned out), planes and trajectory.
CalibrationSnapshot MakeSnapshot(const std::string& stage, int iteration, const Rig& rig,
                                 const Dataset& dataset, const CalibrationState& state,
                                 const PlaneAssociation& planes, const std::vector<PoseSigma>& sigmas,
                                 double cost);

}  // namespace mlic
