#pragma once

#include <string>
#include <vector>

#include "mlic/Status.h"
#include "mlic_core/pipeline/run_progress.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// What /mlic/status says, from what the calibration tells. Times: s since any one moment.
class StatusBoard {
 public:
  StatusBoard();

  void SetPlan(std::vector<PlannedStage> plan);
  void SetRig(const Rig& rig);
  // True if it is another stage than before.
  bool SetProgress(const std::string& stage, double fraction, double now);
  void AddSnapshot(const CalibrationSnapshot& snapshot);
  void SetResult(const CalibrationResult& result);
  // state: FAILED or INTERRUPTED.
  void SetEnd(std::uint8_t state, const std::string& line);
  // The time left as of now; while the calibration runs.
  void Tick(double now);

  // The stamp is the publisher's to set.
  const Status& Get() const { return status_; }

 private:
  SensorStatus* Find(const std::string& name);
  // Keeps what the rig file says of it.
  void Put(const SensorStatus& sensor);

  Status status_;
  RunProgress progress_;
};

}  // namespace mlic
