#pragma once

#include <string>
#include <vector>

#include "mlic_core/pipeline/options.h"
#include "mlic_core/pipeline/stage_store.h"
#include "mlic_core/pipeline/stopwatch.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// What every stage of a run has to do with.
struct StageContext {
  const Rig& rig;
  const Dataset& dataset;
  const CalibrationOptions& options;
  const CancellationToken& cancellation;
  CalibrationObserver& observer;
  StageStore* store;  // null: nothing is kept
  CalibrationResult* result;

  template <typename Stage>
  bool Load(const std::string& name, Stage* stage) const {
    return store != nullptr && store->Load(name, stage);
  }
  template <typename Stage>
  void Save(const std::string& name, const Stage& stage) const {
    if (store != nullptr) store->Save(name, stage);
  }
};

// Times one stage and passes its progress and lines on.
class StageClock : public ProgressSink {
 public:
  StageClock(std::string name, const StageContext& context)
      : observer_(context.observer), result_(context.result) {
    summary_.name = std::move(name);
    observer_.OnProgress(summary_.name, 0.0);
  }
  ~StageClock() override {
    stopwatch_.Read(&summary_);
    result_->stages.push_back(summary_);
  }
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;

  void Line(const std::string& line) {
    summary_.lines.push_back(line);
    observer_.OnMessage(summary_.name + ": " + line);
  }
  void Progress(double fraction) { observer_.OnProgress(summary_.name, fraction); }
  // Of a part of the stage.
  void OnProgress(const std::string& part, double fraction) override {
    observer_.OnProgress(summary_.name + " (" + part + ")", fraction);
  }
  // lines: what an earlier run said, for the report.
  void TakeOver(const std::vector<std::string>& lines, const std::string& how_far = "") {
    summary_.lines = lines;
    Line("reused from an earlier run" + how_far);
  }
  const std::vector<std::string>& lines() const { return summary_.lines; }

 private:
  CalibrationObserver& observer_;
  CalibrationResult* result_;
  Stopwatch stopwatch_;
  StageSummary summary_;
};

}  // namespace mlic
