#include "mlic_ros/programs/drive_evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"
#include "mlic_core/evaluation/birds_eye.h"
#include "mlic_core/evaluation/epipolar_error.h"
#include "mlic_core/evaluation/layering.h"
#include "mlic_core/evaluation/map_builder.h"
#include "mlic_core/evaluation/map_colours.h"
#include "mlic_core/evaluation/map_evaluation.h"
#include "mlic_core/evaluation/map_reprojection.h"
#include "mlic_core/evaluation/methods/hand_eye_method.h"
#include "mlic_core/evaluation/methods/method_table.h"
#include "mlic_core/evaluation/methods/pairwise_method.h"
#include "mlic_core/evaluation/repeatability.h"
#include "mlic_core/evaluation/single_frames.h"
#include "mlic_core/evaluation/trajectory_error.h"
#include "mlic_core/evaluation/turned_entropy.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/bag/bag_loader.h"
#include "mlic_ros/bag/pose_topic.h"
#include "mlic_ros/programs/evaluation_inputs.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostMapPoints = 1000000;  // from: guard, memory and time

constexpr const char* kTruth = "truth";

class Silence : public ProgressSink {
 public:
  void OnProgress(const std::string&, double) override {}
};

// Another calibration of the same sensors, and the words for it.
struct Other {
  std::string name;   // in tables of columns
  std::string title;  // "map quality, ..."
  std::string file;   // part of the files' names
  CalibrationResult sensors;
};

// The calibration, and what it is compared with; all stand on the same trajectory.
struct Compared {
  CalibrationResult calibration;
  std::optional<CalibrationResult> truth;
  std::vector<Other> others;
  std::vector<StampedPose> trajectory;

  // What `measure` gives of the calibration and of each other, each with its name.
  template <typename Column, typename Measure>
  std::vector<Column> Columns(const Measure& measure) const {
    std::vector<Column> columns{{"calibration", measure(calibration)}};
    for (const Other& other : others) {
      columns.push_back({other.name, measure(WithPosesOf(calibration, other.sensors))});
    }
    return columns;
  }
};

std::size_t CountPoints(const Drive& drive) {
  std::size_t count = 0;
  for (const LidarRecording& lidar : drive.lidars) {
    for (const LidarScan& scan : lidar.scans) count += scan.points.size();
  }
  return count;
}

std::vector<std::string> LidarNames(const Rig& rig) {
  std::vector<std::string> names;
  for (const LidarConfig& lidar : rig.lidars) names.push_back(lidar.name);
  return names;
}

std::vector<std::string> CameraNames(const Rig& rig) {
  std::vector<std::string> names;
  for (const CameraConfig& camera : rig.cameras) names.push_back(camera.name);
  return names;
}

// Every so many points of a drive take part in its map.
std::size_t MapStride(const Drive& drive) { return CountPoints(drive) / kMostMapPoints + 1; }

void EvaluateMaps(const BagSet& bags, const Rig& rig, const Drive& drive, const Compared& compared,
                  const CancellationToken& cancellation, Evaluation* evaluation) {
  const std::vector<std::string> names = LidarNames(rig);
  if (names.empty()) return;
  const std::size_t stride = MapStride(drive);
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
  for (const Other& other : compared.others) {
    add("map quality, " + other.title + " (on the same trajectory)", "map_quality_" + other.file + ".csv",
        WithPosesOf(compared.calibration, other.sensors));
  }
  cancellation.ThrowIfCancelled();
  const auto turned = EntropyOfTurnedLidars(drive, names, compared.trajectory, compared.calibration, stride);
  evaluation->Add("mean entropy of each LiDAR's own map", TableOf(turned), "turned_entropy.csv",
                  CsvOf(turned));
}

// The matches are the same for all calibrations.
void EvaluateCameras(const DriveEvaluationOptions& options, const Rig& rig, const Drive& drive,
                     const Compared& compared, const CancellationToken& cancellation,
                     Evaluation* evaluation) {
  if (rig.cameras.size() < 2) return;
  const std::vector<FreshMatch> matches =
      FindFreshMatches(drive, CameraNames(rig), compared.calibration, compared.trajectory,
                       ReadKeyframesBeside(options.calibration), FreshMatchOptions(), cancellation);
  const auto columns = compared.Columns<EpipolarColumn>([&](const CalibrationResult& calibration) {
    return MeasureEpipolarErrors(matches, calibration, compared.trajectory);
  });
  double worst = 0.0;
  for (const EpipolarStatistics& error : columns.front().errors) worst = std::max(worst, error.median);
  if (worst > 0.0) {
    evaluation->findings.push_back("median epipolar errors at most " + FixedNumber(worst, 2) + " px");
  }
  evaluation->Add("epipolar errors of new matches", TableOf(columns), "epipolar_errors.csv", CsvOf(columns));
}

// How far the LiDARs' map is from photos; the matches are the same for all calibrations.
void EvaluateReprojection(const DriveEvaluationOptions& options, const Rig& rig, const Dataset& dataset,
                          const Compared& compared, const CancellationToken& cancellation,
                          Evaluation* evaluation) {
  if (rig.cameras.empty() || rig.lidars.empty()) return;
  const MapSightings sightings = FindMapSightings(rig, dataset, compared.calibration, compared.trajectory,
                                                  ReadKeyframesBeside(options.calibration), cancellation);
  const auto columns = compared.Columns<ReprojectionColumn>([&](const CalibrationResult& calibration) {
    return MeasureReprojection(sightings, calibration, compared.trajectory, dataset.drives.front().epoch);
  });
  double worst = 0.0;
  for (const ReprojectionStatistics& error : columns.front().errors) worst = std::max(worst, error.median);
  if (worst > 0.0) {
    evaluation->findings.push_back("median reprojection errors of the LiDARs' map at most " +
                                   FixedNumber(worst, 2) + " px");
  }
  evaluation->Add("reprojection errors of the LiDARs' map in photos that were not keyframes",
                  TableOf(columns), "reprojection_errors.csv", CsvOf(columns));
}

// The map's layers before and after, and what all sensors of a kind see at one moment.
void DrawLidars(const Rig& rig, const Drive& drive, const Compared& compared,
                const CancellationToken& cancellation, Evaluation* evaluation) {
  if (rig.lidars.empty()) return;
  const std::vector<std::string> names = LidarNames(rig);
  const std::size_t stride = MapStride(drive);
  std::vector<MapState> states;
  const auto add = [&](const std::string& title, const CalibrationResult& poses) {
    cancellation.ThrowIfCancelled();
    states.push_back({title, BuildMap(drive, names, compared.trajectory, poses, stride), {}});
    for (const SensorResult& sensor : poses.sensors) states.back().sensors.push_back(sensor.name);
  };
  const CalibrationResult guess = AtGuesses(compared.calibration, rig);
  if (!guess.sensors.empty()) add("guess of the rig file", guess);
  for (const Other& other : compared.others) {
    if (other.name != kTruth) add(other.name, WithPosesOf(compared.calibration, other.sensors));
  }
  add("calibration", compared.calibration);
  const cv::Mat layering = DrawLayering(states);
  if (!layering.empty()) evaluation->pictures.emplace_back("layering.png", layering);
  const cv::Mat scans = DrawScansFromAbove(drive, names, compared.calibration, compared.trajectory);
  if (!scans.empty()) evaluation->pictures.emplace_back("single_scans.png", scans);
}

// The ground from above and the coloured map: what a person sees of a calibration.
void DrawPictures(const Rig& rig, const Drive& drive, const Compared& compared,
                  const CancellationToken& cancellation, Evaluation* evaluation) {
  if (rig.cameras.empty()) return;
  const std::vector<std::string> cameras = CameraNames(rig), lidars = LidarNames(rig);
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
  const cv::Mat panorama = DrawPanorama(drive, cameras, compared.calibration, compared.trajectory);
  if (!panorama.empty()) evaluation->pictures.emplace_back("panorama.png", panorama);
  if (!lidars.empty()) {
    const std::vector<MapPoint> map =
        BuildMap(drive, lidars, compared.trajectory, compared.calibration, MapStride(drive));
    evaluation->coloured_map = ColourMap(map, drive, cameras, compared.calibration, compared.trajectory,
                                         MapColourOptions(), cancellation);
    const cv::Mat picture = DrawColouredMap(evaluation->coloured_map, compared.trajectory);
    if (!picture.empty()) evaluation->pictures.emplace_back("coloured_map.png", picture);
    text += "coloured_map.pcd: " + std::to_string(evaluation->coloured_map.size()) + " of " +
            std::to_string(map.size()) + " points of the map have the colours of photos\n";
  }
  evaluation->text += "\n== pictures\n" + text;
}

bool IsAsked(const DriveEvaluationOptions& options, const char* method) {
  return std::count(options.methods.begin(), options.methods.end(), method) > 0;
}

// The rivals' calibrations of the same drive join what is compared, and stand beside the given one.
void CalibrateRivals(const DriveEvaluationOptions& options, const Rig& rig, const Dataset& dataset,
                     const CancellationToken& cancellation, Compared* compared, Evaluation* evaluation) {
  const auto add = [&](const std::string& method, CalibrationResult result) {
    for (const RejectedSensor& sensor : result.rejected) {
      evaluation->text += method + ": " + sensor.reason + "\n";
    }
    evaluation->rivals.emplace_back(method + ".yaml", result);
    compared->others.push_back({method, "by the method " + method, method, std::move(result)});
  };
  if (IsAsked(options, kHandEyeMethod)) {
    add(kHandEyeMethod, CalibrateByHandEye(rig, dataset, compared->calibration, cancellation));
  }
  if (IsAsked(options, kPairwiseMethod)) {
    add(kPairwiseMethod, CalibratePairwise(rig, dataset, cancellation, [](const std::string& pair) {
          std::fprintf(stderr, "evaluate: %s: %s\n", kPairwiseMethod, pair.c_str());
        }));
  }
  if (evaluation->rivals.empty() || !compared->truth) return;
  std::vector<MethodErrors> methods{
      {kJointMethod, CompareWithTruth(compared->calibration, *compared->truth)}};
  for (const Other& other : compared->others) {
    if (other.name == kHandEyeMethod || other.name == kPairwiseMethod) {
      methods.push_back({other.name, CompareWithTruth(other.sensors, *compared->truth)});
    }
  }
  evaluation->Add("methods: errors against the truth", TableOf(methods), "methods.csv", CsvOf(methods));
}

void EvaluateData(const DriveEvaluationOptions& options, const BagSet& bags, Compared* compared,
                  const CancellationToken& cancellation, Evaluation* evaluation) {
  const Rig rig =
      options.rig.empty() ? RigOfCalibration(bags, compared->calibration) : LoadRigFile(options.rig);
  if (rig.lidars.empty() && rig.cameras.empty()) return;
  LoadReport report;
  Silence silence;
  LoadOptions load;
  load.rig_directory = options.rig.parent_path();
  const Dataset dataset = LoadDataset(rig, {options.bag}, load, report, cancellation, silence);
  const Drive& drive = dataset.drives.front();
  CalibrateRivals(options, rig, dataset, cancellation, compared, evaluation);
  if (compared->truth)
    compared->others.push_back({kTruth, "sensors at the truth", "truth", *compared->truth});
  EvaluateMaps(bags, rig, drive, *compared, cancellation, evaluation);
  EvaluateCameras(options, rig, drive, *compared, cancellation, evaluation);
  EvaluateReprojection(options, rig, dataset, *compared, cancellation, evaluation);
  DrawLidars(rig, drive, *compared, cancellation, evaluation);
  DrawPictures(rig, drive, *compared, cancellation, evaluation);
}

}  // namespace

Evaluation EvaluateDrive(const DriveEvaluationOptions& options, const CancellationToken& cancellation) {
  if (options.rig.empty() && (IsAsked(options, kHandEyeMethod) || IsAsked(options, kPairwiseMethod))) {
    throw InputError("--method " + Joined(options.methods, " ") +
                     " calibrates anew; give the rig file with its guesses by --rig");
  }
  Compared compared;
  compared.calibration = ReadCalibrationFile(options.calibration);
  if (!options.truth.empty()) compared.truth = ReadCalibrationFile(options.truth);
  const fs::path initial_file = options.calibration.parent_path() / "initial_calibration.yaml";
  if (fs::exists(initial_file)) {
    compared.others.push_back({"before the joint adjustment", "before the joint adjustment", "initial",
                               ReadCalibrationFile(initial_file)});
  }
  const BagSet bags({options.bag});
  Evaluation evaluation;
  evaluation.text = "verdict: " + VerdictName(compared.calibration.verdict) + "\n";
  if (compared.truth) {
    CompareTo(*compared.truth, "", "", compared.calibration, &evaluation);
    for (const Other& initial : compared.others) {
      CompareTo(*compared.truth, "before the joint adjustment: ", "initial_", initial.sensors, &evaluation);
    }
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
    EvaluateData(options, bags, &compared, cancellation, &evaluation);
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

}  // namespace mlic
