// evaluate --bag FILE.bag --calibration C.yaml [--truth T.yaml] [--reference-topic ODOMETRY]
// [--method hand_eye|pairwise|joint] --output DIR: how good a calibration is, on the data and against a
// truth. evaluate --calibration C1.yaml C2.yaml ... [--truth T.yaml] --output DIR: how well calibrations of
// one rig, of a drive each, agree. evaluate --calibration C.yaml --harp FOLDER --camera NAME [--truth T.yaml]
// --output DIR: how straight a camera's intrinsics make photos of straight bars. Exit statuses: see
// program.h.
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/evaluation/repeatability.h"
#include "mlic_core/io/output_directory.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_ros/programs/drive_evaluation.h"
#include "mlic_ros/programs/evaluation.h"
#include "mlic_ros/programs/harp_evaluation.h"
#include "mlic_ros/programs/interrupt.h"
#include "mlic_ros/programs/program.h"
#include "mlic_ros/programs/supervision.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

struct EvaluateOptions {
  fs::path bag, calibration, truth, rig, harp, output;
  std::vector<fs::path> calibrations;  // all; `calibration` is the first
  std::string reference_topic, camera;
  std::vector<std::string> methods;
};

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

Evaluation Evaluate(const EvaluateOptions& options, const CancellationToken& cancellation) {
  const bool on_data = !options.bag.empty() || !options.harp.empty();
  if (!options.bag.empty() && !options.harp.empty()) {
    throw InputError("--harp needs no --bag; give one of them");
  }
  if (on_data && options.calibrations.size() > 1) {
    throw InputError("--bag and --harp are of one calibration; give one, or several without them");
  }
  if (!options.harp.empty()) return EvaluateHarp(options);
  if (options.bag.empty()) return EvaluateSeveral(options);
  return EvaluateDrive({options.bag, options.calibration, options.truth, options.rig, options.reference_topic,
                        options.methods},
                       cancellation);
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
  app.add_option(
         "--method", options.methods,
         "methods whose columns the tables of --bag have: hand_eye and pairwise calibrate the drive anew, "
         "by the guesses of --rig, beside the joint calibration")
      ->check(CLI::IsMember({mlic::kHandEyeMethod, mlic::kPairwiseMethod, mlic::kJointMethod}))
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
