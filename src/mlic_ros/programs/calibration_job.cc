#include "mlic_ros/programs/calibration_job.h"

#include <algorithm>
#include <cstdio>

#include "mlic_core/io/checkpoint/checkpoint.h"
#include "mlic_core/io/checkpoint/stage_files.h"
#include "mlic_core/io/output_directory.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/write_results.h"
#include "mlic_core/pipeline/calibrator.h"
#include "mlic_core/pipeline/earlier_calibration.h"
#include "mlic_core/pipeline/run_plan.h"
#include "mlic_core/pipeline/stage_names.h"
#include "mlic_core/pipeline/stopwatch.h"
#include "mlic_core/sensors/sensor_problem.h"
#include "mlic_ros/programs/finished_run.h"
#include "mlic_ros/programs/job_log.h"
#include "mlic_ros/programs/program.h"
#include "mlic_ros/programs/run_record.h"
#include "mlic_ros/programs/thread_limit.h"

namespace mlic {
namespace {

const char* const kProgram = "calibrate";

StageSummary LoadingSummary(const LoadReport& report, const Stopwatch& stopwatch) {
  StageSummary summary;
  summary.name = stage_names::kLoading;
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

// What of the result others have to know besides what the stages said.
void AddWarnings(const LoadReport& report, CalibrationResult* result) {
  std::vector<std::string>& warnings = result->warnings;
  warnings.insert(warnings.begin(), report.warnings.begin(), report.warnings.end());
  const std::vector<std::string> notes = FramesOf(*result).notes;
  warnings.insert(warnings.end(), notes.begin(), notes.end());
}

// The rig file with what the prior says of its sensors; notes and warnings: lines for the log.
struct GivenRig {
  Rig rig;
  RunRecord run;
  std::vector<std::string> notes, warnings;
};

GivenRig ReadRig(JobOptions* options) {
  GivenRig given{LoadRigFile(options->rig), RecordRun(*options), {}, {}};
  if (options->prior.empty()) return given;
  const CalibrationResult earlier = ReadCalibrationFile(options->prior);
  try {
    if (options->added.empty()) {
      given.rig = WithPrior(given.rig, earlier, &given.notes);
      for (const std::string& bag :
           SharedInputs(given.run, earlier.run.value_or(RunRecord()), options->bags)) {
        given.warnings.push_back(options->prior.string() + ": the prior was made of " + bag +
                                 " too, so that its evidence counts twice and sigmas are too small");
      }
    } else {
      given.rig = WithAddedSensors(given.rig, earlier, options->added, &given.notes);
      options->calibration.held_from = earlier;
    }
  } catch (const InputError& error) {
    throw InputError(options->prior.string() + ": " + error.what());
  }
  return given;
}

// A recording, and what of the rig it shows.
struct Recording {
  Rig rig;
  Dataset dataset;
  LoadReport report;
  std::vector<RejectedSensor> unusable;
};

// The rig loses the sensor, which is returned.
RejectedSensor LeaveOut(const UnusableSensor& problem, Rig* rig) {
  const std::size_t i = problem.Sensor().index;
  const auto take = [&](auto& sensors, SensorResult::Type type) {
    RejectedSensor lost{sensors[i].name, type, sensors[i].name + ": " + problem.what(), sensors[i].frame_id};
    sensors.erase(sensors.begin() + static_cast<std::ptrdiff_t>(i));
    return lost;
  };
  return problem.Sensor().IsLidar() ? take(rig->lidars, SensorResult::Type::kLidar)
                                    : take(rig->cameras, SensorResult::Type::kCamera);
}

// Sensors whose data cannot be used are left out, as long as there are others.
Recording Load(const JobOptions& options, const Rig& rig_file, const CancellationToken& cancellation,
               JobLog& log) {
  LoadOptions load = options.load;
  load.rig_directory = options.rig.parent_path();
  Recording recording;
  recording.rig = rig_file;
  for (;;) {
    log.OnPlan(PlanRun(recording.rig, options.calibration));
    recording.report = {};
    try {
      recording.dataset = LoadDataset(recording.rig, options.bags, load, recording.report, cancellation, log);
      break;
    } catch (const UnusableSensor& problem) {
      if (recording.rig.lidars.size() + recording.rig.cameras.size() == 1) throw;
      recording.unusable.push_back(LeaveOut(problem, &recording.rig));
      log.Warning("warning: left out: " + recording.unusable.back().reason);
    }
  }
  recording.rig = WithMessageFrames(recording.rig, recording.report);
  return recording;
}

CalibrationResult Run(const JobOptions& options, const GivenRig& given, const CancellationToken& cancellation,
                      StageStore& stages, JobLog& log) {
  const Stopwatch stopwatch;
  for (const std::string& line : given.notes) log.Line(line);
  for (const std::string& line : given.warnings) log.Warning("warning: " + line);
  const Recording recording = Load(options, given.rig, cancellation, log);
  const LoadReport& report = recording.report;
  for (const std::string& line : report.lines) log.Line(line);
  for (const std::string& line : report.warnings) log.Warning("warning: " + line);
  const StageSummary loading = LoadingSummary(report, stopwatch);
  log.OnRig(recording.rig);

  CalibrationOptions calibration = options.calibration;
  calibration.colmap_directory = options.output / "stages" / "colmap";
  calibration.unusable = recording.unusable;
  CalibrationResult result =
      Calibrate(recording.rig, recording.dataset, cancellation, log, &stages, calibration);
  result.stages.insert(result.stages.begin(), loading);
  AddWarnings(report, &result);
  result.warnings.insert(result.warnings.begin(), given.warnings.begin(), given.warnings.end());
  result.run = given.run;
  LogTimes(result.stages, &log);
  cancellation.ThrowIfCancelled();
  return result;
}

CalibrationResult RunAndWrite(const JobOptions& options, const GivenRig& given, const std::string& key,
                              const CancellationToken& cancellation, OutputDirectory& output, JobLog& log) {
  const std::filesystem::path stages = output.Path() / "stages";
  if (options.fresh) CheckpointStore(stages).Clear();
  StageFiles files(stages, key, [&](const std::string& line) { log.Line(line); });
  const CalibrationResult result = Run(options, given, cancellation, files, log);
  const std::vector<std::string> kept = output.Replace(
      [&](const std::filesystem::path& directory) { WriteResults(directory, result, output.Path()); });
  for (const std::string& line : kept) log.Warning("warning: " + line);
  NoteFinishedRun(output, key);
  log.OnResult(result);
  return result;
}

CalibrationResult ReadAgain(Rig rig, const OutputDirectory& output, JobLog& log) {
  log.Line("the results of an earlier run of the same inputs are reused; --fresh (fresh:=true) starts anew");
  const CalibrationResult result = ReadCalibrationFile(output.Path() / "calibration.yaml");
  rig.imu.frame_id = result.imu_frame_id;
  log.OnRig(rig);
  log.OnResult(result);
  return result;
}

JobEnd RunWithLog(const JobOptions& options, const CancellationToken& cancellation, const GivenRig& given,
                  const std::string& key, OutputDirectory& output, JobObserver& display) {
  const bool reuse = !options.fresh && IsFinished(output, key);
  JobLog log(output.Path(), reuse, display);
  JobEnd end;
  try {
    const ThreadLimit threads(options.threads);
    const CalibrationResult result = reuse ? ReadAgain(given.rig, output, log)
                                           : RunAndWrite(options, given, key, cancellation, output, log);
    end = EndWithResult(result, output.Path());
  } catch (...) {
    end = EndWithException(output.Path() / JobLog::kFileName);
  }
  log.FileOnly(end.status == kTrusted || end.status == kPartial, end.lines[0]);
  return end;
}

}  // namespace

JobEnd RunCalibrationJob(const std::function<JobOptions()>& make_options,
                         const CancellationToken& cancellation, JobObserver& display) {
  JobEnd end;
  try {
    JobOptions options = make_options();
    OutputDirectory::Check(options.output, kProgram);
    const GivenRig given = ReadRig(&options);
    const std::string key = InputKey(options);
    OutputDirectory output(options.output, kProgram);
    end = RunWithLog(options, cancellation, given, key, output, display);
  } catch (...) {
    end = EndWithException({});
  }
  const bool with_result = end.status == kTrusted || end.status == kPartial || end.status == kRefused;
  if (end.status == kInterrupted) {
    display.OnInterruption(end.lines[0]);
  } else if (!with_result) {
    display.OnFailure(end.lines[0]);
  }
  return end;
}

}  // namespace mlic
