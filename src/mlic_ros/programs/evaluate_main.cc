// evaluate --bag FILE.bag --calibration C.yaml [--truth T.yaml] [--reference-topic ODOMETRY] --output DIR:
// how good a calibration is, on the data and against a truth.
// evaluate --calibration C1.yaml C2.yaml ... [--truth T.yaml] --output DIR: how well calibrations of one rig,
// of a drive each, agree.
// evaluate --calibration C.yaml --harp FOLDER --camera NAME [--truth T.yaml] --output DIR: how straight a
// camera's intrinsics make photos of straight bars.
// Exit statuses: see program.h.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"
#include "mlic_core/evaluation/birds_eye.h"
#include "mlic_core/evaluation/epipolar_error.h"
#include "mlic_core/evaluation/intrinsics_error.h"
#include "mlic_core/evaluation/map_builder.h"
#include "mlic_core/evaluation/map_colours.h"
#include "mlic_core/evaluation/map_evaluation.h"
#include "mlic_core/evaluation/repeatability.h"
#include "mlic_core/evaluation/trajectory_error.h"
#include "mlic_core/evaluation/truth_comparison.h"
#include "mlic_core/evaluation/turned_entropy.h"
#include "mlic_core/io/output_directory.h"
#include "mlic_core/io/result/point_cloud_file.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/bag/bag_loader.h"
#include "mlic_ros/bag/pose_topic.h"
#include "mlic_ros/programs/evaluation_inputs.h"
#include "mlic_ros/programs/harp_evaluation.h"
#include "mlic_ros/programs/interrupt.h"
#include "mlic_ros/programs/program.h"
#include "mlic_ros/programs/supervision.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostMapPoints = 1000000;  // from: guard, memory and time

struct EvaluateOptions {
  fs::path bag, calibration, truth, rig, harp, output;
  std::vector<fs::path> calibrations;  // all; `calibration` is the first
  std::string reference_topic, camera;
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

// Tables for evaluation.txt and the screen, CSV files and pictures by name. Written together once all is
// done.
struct Evaluation {
  std::string text;
  std::vector<std::pair<std::string, std::string>> files;
  std::vector<std::pair<std::string, cv::Mat>> pictures;  // PNG
  std::vector<ColouredPoint> coloured_map;
  std::vector<std::string> findings;  // for the last line, where there is no truth

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
    return map;
  };
  const MapEvaluation found = add("map quality, calibration", "map_quality.csv", compared.calibration);
  if (found.all.queries_used == 0) {
    throw InputError("bag " + bags.names() +
                     ": no points within the trajectory; is it the bag that was calibrated?");
  }
  evaluation->findings.push_back("mean map entropy " + FixedNumber(found.all.mean, 3) + " nats");
  double thickest = 0.0;
  for (const OverlapThickness& overlap : found.overlaps) thickest = std::max(thickest, overlap.thickness);
  if (thickest > 0.0) {
    evaluation->findings.push_back("LiDARs' common planes at most " + FixedNumber(1e3 * thickest, 1) +
                                   " mm thick");
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
  double worst = 0.0;
  for (const EpipolarStatistics& error : columns.front().errors) worst = std::max(worst, error.median);
  if (worst > 0.0) {
    evaluation->findings.push_back("median epipolar errors at most " + FixedNumber(worst, 2) + " px");
  }
  evaluation->Add("epipolar errors of new matches", TableOf(columns), "epipolar_errors.csv", CsvOf(columns));
}

// The ground from above and the coloured map: what a person sees of a calibration.
void DrawPictures(const Rig& rig, const Drive& drive, const Compared& compared,
                  const CancellationToken& cancellation, Evaluation* evaluation) {
  if (rig.cameras.empty()) return;
  std::vector<std::string> cameras, lidars;
  for (const CameraConfig& camera : rig.cameras) cameras.push_back(camera.name);
  for (const LidarConfig& lidar : rig.lidars) lidars.push_back(lidar.name);
  std::string text;
  if (StandsOnTheGround(compared.calibration)) {
    const BirdsEye view =
        DrawBirdsEye(drive, cameras, compared.calibration, compared.trajectory, BirdsEyeOptions());
    text += "birds_eye.png: the ground from above, " + std::to_string(std::lround(view.seconds)) +
            " s after the beginning, by " + Joined(view.cameras) + "\n";
    evaluation->pictures.emplace_back("birds_eye.png", view.picture);
  } else {
    text += "no birds_eye.png: calibration.yaml has no ground, or not that of a vehicle\n";
  }
  if (!lidars.empty()) {
    const std::size_t stride = CountPoints(drive) / kMostMapPoints + 1;
    const std::vector<MapPoint> map =
        BuildMap(drive, lidars, compared.trajectory, compared.calibration, stride);
    evaluation->coloured_map = ColourMap(map, drive, cameras, compared.calibration, compared.trajectory,
                                         MapColourOptions(), cancellation);
    const cv::Mat picture = DrawColouredMap(evaluation->coloured_map, compared.trajectory);
    if (!picture.empty()) evaluation->pictures.emplace_back("coloured_map.png", picture);
    text += "coloured_map.pcd: " + std::to_string(evaluation->coloured_map.size()) + " of " +
            std::to_string(map.size()) + " points of the map have the colours of photos\n";
  }
  evaluation->text += "\n== pictures\n" + text;
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
  DrawPictures(rig, drive, compared, cancellation, evaluation);
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
    for (const auto& [name, picture] : evaluation.pictures) {
      std::vector<unsigned char> png;
      cv::imencode(".png", picture, png);
      WriteFileAtomically(directory / name, std::string(png.begin(), png.end()));
    }
    if (!evaluation.coloured_map.empty()) {
      WriteColouredPointCloudFile(directory / "coloured_map.pcd", evaluation.coloured_map);
    }
    WriteFileAtomically(directory / "evaluation.txt", evaluation.text);
  });
  for (const std::string& line : kept) std::fprintf(stderr, "evaluate: %s\n", line.c_str());
  std::fputs(evaluation.text.c_str(), stdout);
}

std::optional<CalibrationResult> ReadTruth(const EvaluateOptions& options) {
  if (options.truth.empty()) return std::nullopt;
  return ReadCalibrationFile(options.truth);
}

Evaluation EvaluateSeveral(const EvaluateOptions& options) {
  std::vector<CalibrationResult> calibrations;
  for (const fs::path& file : options.calibrations) calibrations.push_back(ReadCalibrationFile(file));
  const std::optional<CalibrationResult> truth = ReadTruth(options);
  const Repeatability found = MeasureRepeatability(calibrations, truth ? &*truth : nullptr);
  Evaluation evaluation;
  evaluation.Add(std::to_string(calibrations.size()) + " calibrations", TableOf(found), "repeatability.csv",
                 CsvOf(found));
  return evaluation;
}

Evaluation EvaluateHarp(const EvaluateOptions& options) {
  const HarpEvaluation found = MeasurePhotos(options.harp, options.camera,
                                             ReadCalibrationFile(options.calibration), ReadTruth(options));
  Evaluation evaluation;
  evaluation.Add("calibration harp, " + found.camera, TableOf(found.columns), "harp.csv",
                 CsvOf(found.columns));
  evaluation.files.emplace_back("harp_histogram.csv", HistogramCsvOf(found.columns));
  evaluation.pictures.emplace_back("harp.png", found.picture);
  evaluation.text += "\n" + Conclusion(found.camera, found.columns.front().measurement);
  return evaluation;
}

Evaluation EvaluateDrive(const EvaluateOptions& options, const CancellationToken& cancellation) {
  Compared compared;
  compared.calibration = ReadCalibrationFile(options.calibration);
  compared.truth = ReadTruth(options);
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
  } else if (!evaluation.findings.empty()) {
    evaluation.text += "\nin short: " + Joined(evaluation.findings, "; ") + "\n";
  }
  return evaluation;
}

Evaluation Evaluate(const EvaluateOptions& options, const CancellationToken& cancellation) {
  const bool on_data = !options.bag.empty() || !options.harp.empty();
  if (!options.bag.empty() && !options.harp.empty()) {
    throw InputError("--harp needs no --bag; give one of them");
  }
  if (on_data && options.calibrations.size() > 1) {
    throw InputError("--bag and --harp are of one calibration; give one, or several without them");
  }
  if (!options.harp.empty()) return EvaluateHarp(options);
  return on_data ? EvaluateDrive(options, cancellation) : EvaluateSeveral(options);
}

// The last line of a text.
std::string LastLine(const std::string& text) {
  const std::size_t end = text.find_last_not_of('\n');
  const std::size_t begin = end == std::string::npos ? end : text.rfind('\n', end);
  return end == std::string::npos ? "" : text.substr(begin + 1, end - begin);
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  mlic::EvaluateOptions options;
  CLI::App app(
      "How good a calibration is: map quality, error against a truth, drift against an odometry, "
      "straightness of a calibration harp",
      "evaluate");
  std::string bag, truth, rig, harp, output;
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
  app.add_option("--harp", harp,
                 "folder with photos of straight bars or strings by one camera, in place of a bag")
      ->type_name("DIR");
  app.add_option("--camera", options.camera, "the camera of --harp, where the calibration has several")
      ->type_name("NAME");
  app.add_option("--output", output,
                 "directory for evaluation.txt, CSV files and pictures, empty or new or of an earlier run")
      ->required()
      ->type_name("DIR");
  bool end_launch = false;
  app.add_flag("--end-launch", end_launch)->group("");  // of evaluate.launch
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
  options.harp = harp;
  options.output = output;
  const mlic::CancellationToken& cancellation = mlic::CancelOnSignals();
  std::string conclusion;
  const mlic::ProgramEnd end = mlic::EndOfProgram("evaluate", [&] {
    mlic::OutputDirectory output(options.output, "evaluate");
    const mlic::Evaluation evaluation = mlic::Evaluate(options, cancellation);
    mlic::Write(evaluation, &output);
    conclusion = mlic::LastLine(evaluation.text);
    return mlic::kTrusted;
  });
  if (!end.line.empty()) {
    conclusion = end.line;
    std::fprintf(stderr, "%s\n", end.line.c_str());
  }
  if (end_launch) mlic::EndLaunchWith(end.status, conclusion);
  return end.status;
}
