#pragma once

#include <string>
#include <vector>

#include "mlic_core/pipeline/options.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// A stage that a run goes through, and how long it takes against the others.
struct PlannedStage {
  std::string name;  // as StageClock tells it
  double share = 1.0;
};

// The stages of a calibration of this rig in their order, the loading of bags first. Stages that show to be
// needed on the way (COLMAP for a lost camera, pairs without the IMU) are not among them.
std::vector<PlannedStage> PlanRun(const Rig& rig, const CalibrationOptions& options);

}  // namespace mlic
