// evaluate --bag FILE.bag --calibration C.yaml [--truth T.yaml] [--reference-topic ODOMETRY] --output DIR:
// how good a calibration is, on the data and against a truth.
// evaluate --calibration C1.yaml C2.yaml ... [--truth T.yaml] --output DIR: how well calibrations of one rig,
// of a drive each, agree. Exit statuses: see program.h.
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/evaluation/epipolar_error.h"
#include "mlic_core/evaluation/intrinsics_error.h"
#include "mlic_core/evaluation/map_builder.h"
#include "mlic_core/evaluation/map_evaluation.h"
#include "mlic_core/evaluation/repeatability.h"
#include "mlic_core/evaluation/trajectory_error.h"
#include "mlic_core/evaluation/truth_comparison.h"
#include "mlic_core/evaluation/turned_entropy.h"
#include "mlic_core/io/output_directory.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/bag/bag_loader.h"
#include "mlic_ros/bag/pose_topic.h"
#include "mlic_ros/programs/evaluation_inputs.h"
#include "mlic_ros/programs/interrupt.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostMapPoints = 1000000;  // from: guard, memory and time

struct EvaluateOptions {
  fs::path bag, calibration, truth, rig, output;
  std::vector<fs::path> calibrations;  // all; `calibration` is the first
  std::string reference_topic;
};

class Silence : public ProgressSink {
 public:
  void OnProgress(const std::string&, double) override {}
};

// The calibration, and what it is compared with; all stand on the same trajectory.
struct Compared {
  CalibrationResult calibration;
  std::optional<CalibrationResult> initial, truth;
  std::vector<StampedPose> trajectory;
};

// Tables for evaluation.txt and the screen, CSV files by name. Written together once all is done.
struct Evaluation {
  std::string text;
  std::vector<std::pair<std::string, std::string>> files;

  void Add(const std::string& title, const std::string& table, const std::string& file,
           const std::string& csv) {
    text += (text.empty() ? "" : "\n") + ("== " + title + "\n") + table;
    files.emplace_back(file, csv);
  }
};

std::size_t CountPoints(const Drive& drive) {
  std::size_t count = 0;
  for (const LidarRecording& lidar : drive.lidars) {
    for (const LidarScan& scan : lidar.scans) count += scan.points.size();
  }
  return count;
}

void EvaluateMaps(const BagSet& bags, const Rig& rig, const Drive& drive, const Compared& compared,
                  const CancellationToken& cancellation, Evaluation* evaluation) {
  std::vector<std::string> names;
  for (const LidarConfig& lidar : rig.lidars) names.push_back(lidar.name);
  if (names.empty()) return;
  const std::size_t stride = CountPoints(drive) / kMostMapPoints + 1;
  const auto add = [&](const std::string& title, const std::string& file, const CalibrationResult& poses) {
    cancellation.ThrowIfCancelled();
    const MapEvaluation map = EvaluateMap(BuildMap(drive, names, compared.trajectory, poses, stride), poses);
    evaluation->Add(title, TableOf(map, poses), file, CsvOf(map, poses));
    return map.all;
  };
  const MapEntropy found = add("map quality, calibration", "map_quality.csv", compared.calibration);
  if (found.queries_used == 0) {
    throw InputError("bag " + bags.names() +
                     ": no points within the trajectory; is it the bag that was calibrated?");
  }
  if (compared.initial) {
    add("map quality before the joint adjustment (on the same trajectory)", "map_quality_initial.csv",
        WithPosesOf(compared.calibration, *compared.initial));
  }
  if (compared.truth) {
    add("map quality, sensors at the truth (on the same trajectory)", "map_quality_truth.csv",
        WithPosesOf(compared.calibration, *compared.truth));
  }
  cancellation.ThrowIfCancelled();
  const auto turned = EntropyOfTurnedLidars(drive, names, compared.trajectory, compared.calibration, stride);
  evaluation->Add("mean entropy of each LiDAR's own map", TableOf(turned), "turned_entropy.csv",
                  CsvOf(turned));
}

// The matches are the same for all calibrations.
void EvaluateCameras(const EvaluateOptions& options, const Rig& rig, const Drive& drive,
                     const Compared& compared, const CancellationToken& cancellation,
                     Evaluation* evaluation) {
  if (rig.cameras.size() < 2) return;
  std::vector<std::string> names;
  for (const CameraConfig& camera : rig.cameras) names.push_back(camera.name);
  const std::vector<FreshMatch> matches =
      FindFreshMatches(drive, names, compared.calibration, compared.trajectory,
                       ReadKeyframesBeside(options.calibration), FreshMatchOptions(), cancellation);
  std::vector<EpipolarColumn> columns;
  const auto add = [&](const std::string& name, const CalibrationResult& poses) {
    columns.push_back({name, MeasureEpipolarErrors(matches, poses, compared.trajectory)});
  };
  const CalibrationResult& calibration = compared.calibration;
  add("calibration", calibration);
  if (compared.initial) add("before the joint adjustment", WithPosesOf(calibration, *compared.initial));
  if (compared.truth) add("truth", WithPosesOf(calibration, *compared.truth));
  evaluation->Add("epipolar errors of new matches", TableOf(columns), "epipolar_errors.csv", CsvOf(columns));
}

void EvaluateData(const EvaluateOptions& options, const BagSet& bags, const Compared& compared,
                  const CancellationToken& cancellation, Evaluation* evaluation) {
  const Rig rig =
      options.rig.empty() ? RigOfCalibration(bags, compared.calibration) : LoadRigFile(options.rig);
  if (rig.lidars.empty() && rig.cameras.empty()) return;
  LoadReport report;
  Silence silence;
  LoadOptions load;
  load.rig_directory = options.rig.parent_path();
  const Dataset dataset = LoadDataset(rig, {options.bag}, load, report, cancellation, silence);
  const Drive& drive = dataset.drives.front();
  EvaluateMaps(bags, rig, drive, compared, cancellation, evaluation);
  EvaluateCameras(options, rig, drive, compared, cancellation, evaluation);
}

void CompareTo(const CalibrationResult& truth, const std::string& of, const std::string& prefix,
               const CalibrationResult& calibration, Evaluation* evaluation) {
  const TruthComparison comparison = CompareWithTruth(calibration, truth);
  evaluation->Add(of + "error against the truth", TableOf(comparison), prefix + "errors.csv",
                  CsvOf(comparison));
  const std::vector<IntrinsicsError> intrinsics = CompareIntrinsics(calibration, truth);
  if (intrinsics.empty()) return;
  evaluation->Add(of + "intrinsics against the truth", TableOf(intrinsics), prefix + "intrinsics_errors.csv",
                  CsvOf(intrinsics));
}

void Write(const Evaluation& evaluation, OutputDirectory* output) {
  const std::vector<std::string> kept = output->Replace([&](const fs::path& directory) {
    for (const auto& [name, content] : evaluation.files) WriteFileAtomically(directory / name, content);
    WriteFileAtomically(directory / "evaluation.txt", evaluation.text);
  });
  for (const std::string& line : kept) std::fprintf(stderr, "evaluate: %s\n", line.c_str());
  std::fputs(evaluation.text.c_str(), stdout);
}

int EvaluateSeveral(const EvaluateOptions& options) {
  OutputDirectory output(options.output, "evaluate");
  std::vector<CalibrationResult> calibrations;
  for (const fs::path& file : options.calibrations) calibrations.push_back(ReadCalibrationFile(file));
  std::optional<CalibrationResult> truth;
  if (!options.truth.empty()) truth = ReadCalibrationFile(options.truth);
  const Repeatability found = MeasureRepeatability(calibrations, truth ? &*truth : nullptr);
  Evaluation evaluation;
  evaluation.Add(std::to_string(calibrations.size()) + " calibrations", TableOf(found), "repeatability.csv",
                 CsvOf(found));
  Write(evaluation, &output);
  return kTrusted;
}

int Evaluate(const EvaluateOptions& options, const CancellationToken& cancellation) {
  OutputDirectory output(options.output, "evaluate");
  Compared compared;
  compared.calibration = ReadCalibrationFile(options.calibration);
  if (!options.truth.empty()) compared.truth = ReadCalibrationFile(options.truth);
  const fs::path initial_file = options.calibration.parent_path() / "initial_calibration.yaml";
  if (fs::exists(initial_file)) compared.initial = ReadCalibrationFile(initial_file);
  const BagSet bags({options.bag});
  Evaluation evaluation;
  evaluation.text = "verdict: " + VerdictName(compared.calibration.verdict) + "\n";
  if (compared.truth) {
    CompareTo(*compared.truth, "", "", compared.calibration, &evaluation);
    if (compared.initial)
      CompareTo(*compared.truth, "before the joint adjustment: ", "initial_", *compared.initial, &evaluation);
  }
  if (compared.calibration.sensors.empty() && options.reference_topic.empty()) {
    evaluation.text += "no sensor is calibrated to the IMU: there is no map to evaluate\n";
  } else {
    compared.trajectory = ReadTrajectoryBeside(options.calibration);
    if (!options.reference_topic.empty()) {
      const TrajectoryError error =
          CompareTrajectories(compared.trajectory, ReadPoseTopic(bags, options.reference_topic));
      evaluation.Add("trajectory against " + options.reference_topic, TableOf(error), "trajectory_errors.csv",
                     CsvOf(error));
    }
    EvaluateData(options, bags, compared, cancellation, &evaluation);
  }
  cancellation.ThrowIfCancelled();
  if (compared.truth) {
    CalibrationDifference error;
    error.poses = CompareWithTruth(compared.calibration, *compared.truth);
    evaluation.text += "\n" + Conclusion(LargestOf(error));
  }
  Write(evaluation, &output);
  return kTrusted;
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  mlic::EvaluateOptions options;
  CLI::App app("How good a calibration is: map quality, error against a truth, drift against an odometry",
               "evaluate");
  std::string bag, truth, rig, output;
  std::vector<std::string> calibrations;
  app.add_option("--bag", bag, "ROS 1 bag that was calibrated; without it only calibrations are compared")
      ->type_name("FILE");
  app.add_option(
         "--calibration", calibrations,
         "calibration.yaml with trajectory.tum beside it; without --bag several of one rig, each of a drive "
         "of its own")
      ->required()
      ->type_name("FILE");
  app.add_option("--truth", truth, "true calibration, in the same format")->type_name("FILE");
  app.add_option("--reference-topic", options.reference_topic,
                 "topic with the true path: Odometry, PoseStamped or TransformStamped")
      ->type_name("TOPIC");
  app.add_option("--rig", rig, "rig file that names the topics; by default they are found by their frames")
      ->type_name("FILE");
  app.add_option("--output", output,
                 "directory for evaluation.txt and CSV files, empty or new or of an earlier run")
      ->required()
      ->type_name("DIR");
  mlic::Describe(
      app, {{mlic::kTrusted, "evaluated"}, {mlic::kInterrupted, "interrupted"}},
      "rosrun mlic evaluate --bag drive.bag --calibration result/calibration.yaml --output evaluation");
  int status = 0;
  if (!mlic::ParseArguments(app, argc, argv, status)) return status;
  options.bag = bag;
  options.calibrations.assign(calibrations.begin(), calibrations.end());
  options.calibration = calibrations.front();
  options.truth = truth;
  options.rig = rig;
  options.output = output;
  const mlic::CancellationToken& cancellation = mlic::CancelOnSignals();
  return mlic::RunProgram("evaluate", [&] {
    if (bag.empty()) return mlic::EvaluateSeveral(options);
    if (calibrations.size() > 1) {
      throw mlic::InputError("--bag is of one calibration; give one, or several without --bag");
    }
    return mlic::Evaluate(options, cancellation);
  });
}
