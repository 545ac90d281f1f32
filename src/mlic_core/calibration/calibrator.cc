#include "mlic_core/calibration/calibrator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "mlic_core/calibration/association.h"
#include "mlic_core/calibration/initialization.h"
#include "mlic_core/calibration/joint_problem.h"
#include "mlic_core/calibration/observability.h"
#include "mlic_core/calibration/refinement.h"
#include "mlic_core/calibration/result_assembly.h"

namespace mlic {
namespace {

// Times one stage and passes its progress and lines on.
class StageClock {
 public:
  StageClock(std::string name, CalibrationObserver& observer, CalibrationResult* result)
      : observer_(observer), result_(result), start_(std::chrono::steady_clock::now()) {
    summary_.name = std::move(name);
    observer_.OnProgress(summary_.name, 0.0);
  }
  ~StageClock() {
    summary_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    result_->stages.push_back(summary_);
  }
  void Line(const std::string& line) {
    summary_.lines.push_back(line);
    observer_.OnMessage(summary_.name + ": " + line);
  }
  void Progress(double fraction) { observer_.OnProgress(summary_.name, fraction); }
  // lines: what an earlier run said, for the report.
  void TakeOver(const std::vector<std::string>& lines, const std::string& how_far = "") {
    summary_.lines = lines;
    Line("taken over from an earlier run" + how_far);
  }
  const std::vector<std::string>& lines() const { return summary_.lines; }

 private:
  CalibrationObserver& observer_;
  CalibrationResult* result_;
  std::chrono::steady_clock::time_point start_;
  StageSummary summary_;
};

std::vector<DriveOdometry> OdometryStage(const Rig& rig, const Dataset& dataset,
                                         const CancellationToken& cancellation, CalibrationObserver& observer,
                                         StageStore& store, CalibrationResult* result) {
  StageClock stage("LiDAR odometry", observer, result);
  std::vector<DriveOdometry> odometry;
  const double share = 1.0 / static_cast<double>(dataset.drives.size());
  for (const Drive& drive : dataset.drives) {
    const double done = share * static_cast<double>(odometry.size());
    const std::string name = "odometry_" + std::to_string(odometry.size() + 1);
    DriveOdometry of_drive;
    if (store.Load(name, &of_drive)) {
      stage.TakeOver(stage.lines());
    } else {
      of_drive =
          RunDriveOdometry(rig, drive, cancellation, [&](double f) { stage.Progress(done + share * f); });
      store.Save(name, of_drive);
    }
    odometry.push_back(std::move(of_drive));
    for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
      const AngularRateAlignment& a = odometry.back().alignments[l];
      char line[200];
      std::snprintf(
          line, sizeof(line), "%s: offset %.2f ms, agrees with the gyroscope to %.3f deg (correlation %.3f)",
          rig.lidars[l].name.c_str(), 1e3 * a.time_offset, a.residual_rms * 180.0 / M_PI, a.peak_correlation);
      stage.Line(a.valid ? line : rig.lidars[l].name + ": " + a.failure);
    }
  }
  return odometry;
}

Initialization InitializationStage(const Rig& rig, const Dataset& dataset,
                                   const std::vector<DriveOdometry>& odometry,
                                   const CancellationToken& cancellation, CalibrationObserver& observer,
                                   StageStore& store, CalibrationResult* result) {
  StageClock stage("initialisation", observer, result);
  Initialization start;
  if (store.Load("initialisation", &start)) {
    stage.TakeOver({});
  } else {
    start = Initialize(rig, dataset, odometry, cancellation);
    store.Save("initialisation", start);
  }
  for (const std::string& note : start.notes) stage.Line(note);
  for (const std::string& problem : start.problems) stage.Line(problem);
  return start;
}

void Keep(const Refinement& refinement, const StageClock& stage, const std::string& name, StageStore& store) {
  RefinementProgress progress = refinement.Checkpoint();
  progress.lines = stage.lines();
  store.Save(name, progress);
}

void LidarAdjustmentStage(CalibrationObserver& observer, StageStore& store, CalibrationResult* result,
                          Refinement* refinement) {
  constexpr const char* kName = "lidar_adjustment";
  StageClock stage("plane adjustment of each LiDAR", observer, result);
  RefinementProgress kept;
  if (store.Load(kName, &kept)) {
    refinement->Restore(kept);
    stage.TakeOver(kept.lines);
    return;
  }
  refinement->AdjustEachLidar([&](double fraction) { stage.Progress(fraction); },
                              [&](const std::string& line) { stage.Line(line); });
  Keep(*refinement, stage, kName, store);
}

void JointAdjustmentStage(CalibrationObserver& observer, StageStore& store, CalibrationResult* result,
                          Refinement* refinement) {
  constexpr const char* kName = "joint_adjustment";
  StageClock stage("joint adjustment", observer, result);
  RefinementProgress kept;
  if (store.Load(kName, &kept)) {
    refinement->Restore(kept);
    stage.TakeOver(kept.lines, " up to round " + std::to_string(kept.rounds));
  }
  refinement->AdjustJointly([&](double fraction) { stage.Progress(fraction); },
                            [&](const std::string& line) { stage.Line(line); },
                            [&] { Keep(*refinement, stage, kName, store); });
}

}  // namespace

CalibrationResult Calibrate(const Rig& rig, const Dataset& dataset, const CancellationToken& cancellation,
                            CalibrationObserver& observer) {
  NoStageStore no_store;
  return Calibrate(rig, dataset, cancellation, observer, no_store);
}

CalibrationResult Calibrate(const Rig& rig, const Dataset& dataset, const CancellationToken& cancellation,
                            CalibrationObserver& observer, StageStore& store) {
  CalibrationResult result;
  result.imu_frame_id = rig.imu.frame_id;
  if (rig.lidars.empty()) {
    throw InputError("the rig file has no enabled LiDAR under 'lidars'; at least one is needed");
  }
  const auto odometry = OdometryStage(rig, dataset, cancellation, observer, store, &result);
  Initialization start = InitializationStage(rig, dataset, odometry, cancellation, observer, store, &result);
  if (start.state.drives.size() < dataset.drives.size()) {
    result.reasons = start.problems;
    FinishRefused(&result);
    return result;
  }
  result.warnings = start.problems;

  Refinement refinement(rig, dataset, std::move(start), cancellation, observer);
  if (rig.lidars.size() > 1) LidarAdjustmentStage(observer, store, &result, &refinement);
  JointAdjustmentStage(observer, store, &result, &refinement);
  AssembleResult(rig, dataset, refinement, &result);
  return result;
}

}  // namespace mlic
