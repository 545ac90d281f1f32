#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/pipeline/run_plan.h"

namespace mlic {

// How far a run is on its plan, from what its stages tell, and how long it still takes. All times: s since
// any one moment.
class RunProgress {
 public:
  explicit RunProgress(std::vector<PlannedStage> plan = {}) : plan_(std::move(plan)) {}

  // As ProgressSink::OnProgress. A stage that is not on the plan, or that comes again, is taken for part of
  // the present one. What stages say of their parts, "stage (part)", counts for nothing but the stage.
  void Report(const std::string& stage, double fraction, double now);

  // Of the present stage, from 1; 0 before the first.
  int StageNumber() const { return static_cast<int>(begun_); }
  int StageCount() const { return static_cast<int>(plan_.size()); }

  // Done share of the whole, 0 to 1; never falls.
  double Done(double now);
  // None as long as no stage has shown how fast this machine is on this drive.
  std::optional<double> SecondsLeft(double now) const;

 private:
  double ShareDone(double now) const;
  double ShareOfAll() const;
  // Seconds that a share of one takes, where that is known.
  std::optional<double> Pace(double now) const;

  std::vector<PlannedStage> plan_;
  std::size_t begun_ = 0;  // stages of the plan; the last of them is the present one
  double stage_start_ = 0.0;
  double fraction_ = 0.0;                                 // of the present stage, as told
  double measured_seconds_ = 0.0, measured_share_ = 0.0;  // of finished stages that did work
  double shown_ = 0.0;
};

}  // namespace mlic
