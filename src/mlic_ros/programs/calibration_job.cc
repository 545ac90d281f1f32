#include "mlic_ros/programs/calibration_job.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "mlic_core/common/error.h"
#include "mlic_core/io/checkpoint/checkpoint.h"
#include "mlic_core/io/checkpoint/stage_files.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/write_results.h"
#include "mlic_core/pipeline/calibrator.h"
#include "mlic_core/pipeline/stopwatch.h"
#include "mlic_ros/programs/finished_run.h"
#include "mlic_ros/programs/job_log.h"
#include "mlic_ros/programs/result_directory.h"

extern "C" void openblas_set_num_threads(int threads);

namespace mlic {
namespace {

// All parallel loops within its lifetime use this many threads.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads) {
    if (threads > 0) {
      limit_ = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                     static_cast<std::size_t>(threads));
    }
    openblas_set_num_threads(threads > 0 ? threads : DefaultThreads());
  }

 private:
  static int DefaultThreads() {
    return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  }
  std::unique_ptr<tbb::global_control> limit_;
};

StageSummary LoadingSummary(const LoadReport& report, const Stopwatch& stopwatch) {
  StageSummary summary;
  summary.name = "loading";
  stopwatch.Read(&summary);
  summary.lines = report.lines;
  return summary;
}

// Where the time went: one line for each stage.
void LogTimes(const std::vector<StageSummary>& stages, JobLog* log) {
  StageSummary all;
  all.name = "all stages";
  const auto line = [&](const StageSummary& stage) {
    char text[160];
    std::snprintf(text, sizeof(text), "time: %7.1f s, processor %7.1f s: %s", stage.seconds,
                  stage.processor_seconds, stage.name.c_str());
    log->FileOnly(true, text);
  };
  for (const StageSummary& stage : stages) {
    line(stage);
    all.seconds += stage.seconds;
    all.processor_seconds += stage.processor_seconds;
  }
  line(all);
}

std::string RefusalLine(const CalibrationResult& result) {
  std::string line = "refused: ";
  for (std::size_t i = 0; i < result.reasons.size(); ++i) line += (i == 0 ? "" : "; ") + result.reasons[i];
  if (result.reasons.empty()) line += "a check failed";
  return line +
         "; what was shown stands in calibration.yaml, record a drive with more turns or give T_imu_sensor";
}

JobOutcome Run(const JobOptions& options, const Rig& rig_file, const CancellationToken& cancellation,
               StageStore& stages, JobLog& log) {
  const Stopwatch stopwatch;
  LoadReport report;
  LoadOptions load = options.load;
  load.rig_directory = options.rig.parent_path();
  const Dataset dataset = LoadDataset(rig_file, options.bags, load, report, cancellation, log);
  const Rig rig = WithMessageFrames(rig_file, report);
  for (const std::string& line : report.lines) log.Line(line);
  for (const std::string& line : report.warnings) log.Warning("warning: " + line);
  const StageSummary loading = LoadingSummary(report, stopwatch);
  log.OnRig(rig);

  CalibrationOptions calibration = options.calibration;
  calibration.colmap_directory = options.output / "stages" / "colmap";
  CalibrationResult result = Calibrate(rig, dataset, cancellation, log, &stages, calibration);
  result.stages.insert(result.stages.begin(), loading);
  result.warnings.insert(result.warnings.begin(), report.warnings.begin(), report.warnings.end());
  LogTimes(result.stages, &log);
  cancellation.ThrowIfCancelled();
  ReplaceResults(options.output,
                 [&](const std::filesystem::path& directory) { WriteResults(directory, result); });
  log.OnResult(result);
  return {result.trusted, result.trusted ? "" : RefusalLine(result)};
}

JobOutcome RunOrReuse(const JobOptions& options, const CancellationToken& cancellation, JobLog& log) {
  const Rig rig = LoadRigFile(options.rig);
  const std::string key = InputKey(options);
  if (!options.fresh) {
    const auto finished = FindFinishedRun(options.output, key);
    if (finished) {
      log.Line("the results of an earlier run of the same inputs are reused; --fresh starts anew");
      return *finished;
    }
  }
  const std::filesystem::path stages = options.output / "stages";
  if (options.fresh) CheckpointStore(stages).Clear();
  StageFiles files(stages, key, [&](const std::string& line) { log.Line(line); });
  const JobOutcome outcome = Run(options, rig, cancellation, files, log);
  NoteFinishedRun(options.output, key, outcome);
  return outcome;
}

}  // namespace

JobOutcome RunCalibrationJob(const JobOptions& options, const CancellationToken& cancellation,
                             JobObserver& display) {
  JobLog log(options.output, display);
  const ThreadLimit threads(options.threads);
  try {
    const JobOutcome outcome = RunOrReuse(options, cancellation, log);
    log.FileOnly(outcome.trusted, outcome.trusted ? "trusted" : outcome.refusal);
    return outcome;
  } catch (const std::exception& error) {
    log.FileOnly(false, error.what());
    throw;
  }
}

std::string LogHint(const JobOptions& options) { return "; see " + (options.output / "log.txt").string(); }

}  // namespace mlic
