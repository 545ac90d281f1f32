#pragma once

#include <string>
#include <vector>

#include "mlic_core/pipeline/run_plan.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// A display of the job: besides what the calibration shows, the stages that it will go through, the rig once
// its frames are known, and the result, or in one line why there is none.
class JobObserver : public CalibrationObserver {
 public:
  virtual void OnPlan(const std::vector<PlannedStage>& /*plan*/) {}
  virtual void OnRig(const Rig& /*rig*/) {}
  virtual void OnResult(const CalibrationResult& /*result*/) {}
  virtual void OnFailure(const std::string& /*line*/) {}
  virtual void OnInterruption(const std::string& /*line*/) {}
};

}  // namespace mlic
