#pragma once

#include <string>

#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// A display of the job: besides what the calibration shows, the rig once its frames are known, and the
// result, or in one line why there is none.
class JobObserver : public CalibrationObserver {
 public:
  virtual void OnRig(const Rig& /*rig*/) {}
  virtual void OnResult(const CalibrationResult& /*result*/) {}
  virtual void OnFailure(const std::string& /*line*/) {}
};

}  // namespace mlic
