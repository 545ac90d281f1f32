#include "mlic_core/pipeline/calibrator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/initialization/camera_imu/camera_imu.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/pipeline/adjustment_context.h"
#include "mlic_core/pipeline/camera_stages.h"
#include "mlic_core/pipeline/earlier_calibration.h"
#include "mlic_core/pipeline/joint_adjustment.h"
#include "mlic_core/pipeline/kept_adjustment.h"
#include "mlic_core/pipeline/lidar_adjustment.h"
#include "mlic_core/pipeline/odometry_stage.h"
#include "mlic_core/pipeline/pair_stage.h"
#include "mlic_core/pipeline/stage_clock.h"
#include "mlic_core/pipeline/stage_names.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/summary/checks.h"
#include "mlic_core/summary/result_assembly.h"
#include "mlic_core/summary/snapshot.h"
#include "mlic_core/uncertainty/split_halves.h"

namespace mlic {
namespace {

// make: the first state, and the cameras where the stage finds them as well (null: it does not). suffix: of
// the names under which they are kept.
template <typename Make>
Initialization InitializationStage(const StageContext& context, const std::string& suffix,
                                   CameraInitialization* cameras, const Make& make) {
  StageClock stage(stage_names::kInitialization, context);
  Initialization start;
  if (context.Load("initialisation" + suffix, &start) &&
      (cameras == nullptr || context.Load("cameras" + suffix, cameras))) {
    stage.TakeOver({});
  } else {
    start = make();
    if (cameras != nullptr) context.Save("cameras" + suffix, *cameras);
    context.Save("initialisation" + suffix, start);
  }
  for (const std::string& note : start.notes) stage.Line(note);
  for (const std::string& problem : start.problems) stage.Line(problem);
  return start;
}

Adjustment LidarAdjustmentStage(const StageContext& context, Adjustment adjustment) {
  constexpr const char* kFile = "lidar_adjustment";
  StageClock stage(stage_names::kEachLidar, context);
  const AdjustmentContext of_stage = ContextOf(context, &stage);
  bool found;
  adjustment = TakeOver(context, kFile, adjustment, &found);
  if (found) {
    stage.TakeOver(adjustment.lines);
  } else {
    adjustment = AdjustEachLidar(std::move(adjustment), of_stage);
    Keep(context, stage, kFile, adjustment);
  }
  RejectLostLidars(of_stage, &adjustment);
  return adjustment;
}

const char* FileOf(Landmarks landmarks) {
  switch (landmarks) {
    case Landmarks::kNone:
      return "joint_adjustment";
    case Landmarks::kTracks:
      return "joint_adjustment_cameras";
    case Landmarks::kTracksAndMap:
      return "joint_calibration";
  }
  return "";
}

// last: no other adjustment follows, so that it goes on until the calibration stands still.
Adjustment JointAdjustmentStage(const StageContext& context, Landmarks landmarks, bool last,
                                Adjustment adjustment) {
  StageClock stage(NameOf(landmarks), context);
  const AdjustmentContext of_stage = ContextOf(context, &stage);
  bool found;
  adjustment = TakeOver(context, FileOf(landmarks), adjustment, &found);
  if (found) stage.TakeOver(adjustment.lines, " up to round " + std::to_string(adjustment.rounds.done));
  JointOptions options;
  options.landmarks = landmarks;
  // from: derivation, a check's movements are judged by five sigmas
  constexpr double kSettledForCheck = 0.3;
  options.until = last ? 0.1 : 1.0;
  if (last && context.options.check_of) options.until = kSettledForCheck;
  options.find_imu_axes = !context.options.check_of;
  options.after_round = [&](const Adjustment& now) { Keep(context, stage, FileOf(landmarks), now); };
  adjustment = AdjustJointly(std::move(adjustment), of_stage, options);
  if (last) MeasureUncertainty(of_stage, &adjustment);
  return adjustment;
}

void RejectCameras(const CameraInitialization& cameras, CalibrationResult* result) {
  for (const SensorProblem& problem : cameras.problems) {
    result->rejected.push_back({problem.sensor, SensorResult::Type::kCamera, problem.reason});
  }
}

// The calibration that has the lens and the readout of a camera, where they do not move; null: they move.
const CalibrationResult* EarlierLens(const StageContext& context, const CameraConfig& camera) {
  const CalibrationOptions& options = context.options;
  if (options.check_of) return &*options.check_of;
  return options.held_from && IsHeldFrom(*options.held_from, camera) ? &*options.held_from : nullptr;
}

// Lenses of an earlier calibration are held.
void TakeCameras(const StageContext& context, const CameraInitialization& cameras,
                 const std::vector<TrackSet>& tracks, Adjustment* adjustment) {
  AddCameras(context.rig, cameras, tracks, adjustment);
  for (std::size_t c = 0; c < context.rig.cameras.size(); ++c) {
    if (EarlierLens(context, context.rig.cameras[c]) == nullptr) continue;
    FixedCameraParameters& fixed = adjustment->cameras.always_fixed[c];
    fixed.readout = true;
    fixed.intrinsics.assign(fixed.intrinsics.size(), true);
  }
}

// Shows the cameras as a stage found them, on the trajectory of an adjustment without them.
void ShowCameras(const StageContext& context, const char* stage, const Adjustment& adjustment,
                 const CameraInitialization& cameras) {
  if (cameras.landmarks.empty()) return;
  context.observer.OnSnapshot(MakeSnapshotOfCameras(stage, context.rig, context.dataset, adjustment,
                                                    cameras.cameras, cameras.landmarks[0]));
}

// Brings the cameras together for the search for tracks across them. What the first look loses or takes for
// noise is left as it is.
void LookFirst(const StageContext& context, const std::vector<CameraStart>& intrinsics,
               const std::vector<ImageFeatures>& features, const Adjustment& adjustment,
               CameraInitialization* cameras) {
  CalibrationState state = adjustment.state;
  state.cameras = cameras->cameras;
  CameraInitialization looked = *cameras;
  const auto tracks = SharedTrackStage(context, SharedPass::kFirstLook, state, features);
  SharedCameraStage(context, SharedPass::kFirstLook, intrinsics, tracks, state, &looked);
  ShowCameras(context, stage_names::kFirstSharedCameras, adjustment, looked);
  for (std::size_t c = 0; c < looked.cameras.size(); ++c) {
    if (looked.found[c]) cameras->cameras[c] = looked.cameras[c];
  }
}

Adjustment CameraStages(const StageContext& context, const std::vector<CameraStart>& intrinsics,
                        CameraInitialization cameras, const std::vector<ImageFeatures>& features,
                        Adjustment adjustment) {
  CalibrationState state = adjustment.state;
  const bool map = !context.rig.lidars.empty();
  ShowCameras(context, stage_names::kCameras, adjustment, cameras);
  if (map && cameras.cameras.size() > 1) LookFirst(context, intrinsics, features, adjustment, &cameras);
  state.cameras = cameras.cameras;
  const auto tracks = SharedTrackStage(context, SharedPass::kAll, state, features);
  if (map) {
    SharedCameraStage(context, SharedPass::kAll, intrinsics, tracks, state, &cameras);
    ShowCameras(context, stage_names::kSharedCameras, adjustment, cameras);
    RejectCameras(cameras, context.result);
  }
  TakeCameras(context, cameras, tracks, &adjustment);
  adjustment = JointAdjustmentStage(context, Landmarks::kTracks, !map, std::move(adjustment));
  if (!map) return adjustment;
  return JointAdjustmentStage(context, Landmarks::kTracksAndMap, true, std::move(adjustment));
}

// Whether one calibration serves the whole drive; a check is held against the calibration itself.
void HalvesStage(const StageContext& context, Adjustment* adjustment) {
  if (context.options.check_of) return;
  StageClock stage(stage_names::kHalves, context);
  adjustment->halves = CompareHalves(*adjustment, context.dataset, context.cancellation);
  if (adjustment->halves.empty()) stage.Line("not compared: the equations of one have no solution");
  const SensorOrder order = adjustment->state.Sensors();
  for (std::size_t s = 0; s < adjustment->halves.size(); ++s) {
    const SensorHalves& sensor = adjustment->halves[s];
    const std::string difference = Describe(sensor);
    if (difference.empty()) continue;
    stage.Line(NameOf(order.At(s), context.rig) + ": " + NameOf(sensor.parts) + " differ in " + difference);
  }
}

// What is held of an earlier calibration.
std::vector<CameraStart> StartOfCameras(const StageContext& context) {
  std::vector<CameraStart> starts = StartFromRig(context.rig, context.dataset);
  for (std::size_t c = 0; c < starts.size(); ++c) {
    const CalibrationResult* earlier = EarlierLens(context, context.rig.cameras[c]);
    if (earlier == nullptr) continue;
    starts[c].intrinsics_held = starts[c].readout_held = true;
    for (const SensorResult& sensor : earlier->sensors) {
      if (sensor.name != context.rig.cameras[c].name) continue;
      starts[c].readout = sensor.rolling_shutter_readout.value_or(0.0);
    }
  }
  return starts;
}

Adjustment StartAt(const StageContext& context, Initialization start) {
  Adjustment adjustment = StartAdjustment(context.rig, context.dataset, std::move(start));
  if (context.options.check_of) {
    adjustment.state.gyroscope_matrix = context.options.check_of->imu.gyroscope_matrix;
    adjustment.state.accelerometer_matrix = context.options.check_of->imu.accelerometer_matrix;
    adjustment.state.accelerometer_lag = context.options.check_of->imu.accelerometer_lag;
    adjustment.problem.imu.lag_sigma = 0.0;
  }
  return adjustment;
}

// The cameras start where the calibration has them, so that tracks are sought across them at once.
Adjustment CheckCameras(const StageContext& context, Adjustment adjustment) {
  const std::vector<CameraStart> starts = StartOfCameras(context);
  CalibrationState state = adjustment.state;
  for (std::size_t c = 0; c < starts.size(); ++c) {
    state.cameras.push_back(CameraAsGiven(context.rig.cameras[c], starts[c]));
  }
  const auto features = FeatureStage(context, starts, state);
  const auto tracks = SharedTrackStage(context, SharedPass::kAll, state, features);
  const CameraInitialization found =
      CameraInitializationStage(context, "cameras", starts, tracks, adjustment.state);
  RejectCameras(found, context.result);
  TakeCameras(context, found, tracks, &adjustment);
  return JointAdjustmentStage(context, Landmarks::kTracks, true, std::move(adjustment));
}

void ResultStage(const StageContext& context, const Adjustment& adjustment) {
  StageClock stage(stage_names::kResult, context);
  AssembleResult(context.rig, context.dataset, adjustment, context.result);
  const std::vector<QualityCheck>& checks = context.result->checks;
  const auto passed =
      std::count_if(checks.begin(), checks.end(), [](const QualityCheck& check) { return check.Passed(); });
  stage.Line(std::to_string(passed) + " of " + std::to_string(checks.size()) + " checks passed");
  for (const QualityCheck& check : checks) {
    if (!check.Passed()) stage.Line(DescribeCheck(check));
  }
}

bool ColmapWanted(const StageContext& context) {
  return context.options.intrinsics == IntrinsicsStart::kColmap;
}

std::vector<bool> AllOf(const std::vector<CameraStart>& cameras) {
  return std::vector<bool>(cameras.size(), true);
}

// COLMAP for the cameras that could not be started from their fields of view. Whether one starts from it now.
bool StartLostFromColmap(const StageContext& context, const std::vector<bool>& found,
                         const std::vector<TrackSet>& tracks, std::vector<CameraStart>* intrinsics) {
  if (ColmapWanted(context)) return false;  // all did already
  std::vector<bool> lost;
  for (std::size_t c = 0; c < found.size(); ++c) {
    lost.push_back(!found[c] && (*intrinsics)[c].from_field_of_view);
  }
  if (std::find(lost.begin(), lost.end(), true) == lost.end()) return false;
  return ColmapStage(context, lost, tracks, intrinsics);
}

// The trajectory comes from the cameras themselves and the IMU. suffix: of the names of its first stages.
void CalibrateFromCameras(const StageContext& context, const std::string& suffix) {
  std::vector<CameraStart> intrinsics = StartOfCameras(context);
  const auto features = FeatureStage(context, intrinsics, {});
  const auto tracks = TrackStage(context, intrinsics, features);
  if (ColmapWanted(context)) ColmapStage(context, AllOf(intrinsics), tracks, &intrinsics);
  CameraInitialization cameras;
  const auto initialize = [&] {
    return InitializeFromCameras(context.rig, context.dataset, intrinsics, tracks, context.cancellation,
                                 &cameras);
  };
  Initialization start = InitializationStage(context, suffix, &cameras, initialize);
  if (StartLostFromColmap(context, cameras.found, tracks, &intrinsics)) {
    start = InitializationStage(context, suffix + "_from_colmap", &cameras, initialize);
  }
  CalibrationResult* result = context.result;
  result->reasons = start.problems;
  RejectCameras(cameras, result);
  if (start.state.drives.size() < context.dataset.drives.size()) return FinishRefused(result);
  Adjustment adjustment = StartAt(context, std::move(start));
  adjustment = CameraStages(context, intrinsics, std::move(cameras), features, std::move(adjustment));
  HalvesStage(context, &adjustment);
  ResultStage(context, adjustment);
}

// The cameras by themselves, where no LiDAR can be followed although the vehicle turns: those then stand with
// `reason` among the rejected sensors. False where that gives nothing either; the result then is as it was.
bool CalibrateWithoutLidars(const StageContext& context, const std::string& reason) {
  if (!WithCameras(context) || !TurnsEnough(context.dataset)) return false;
  Rig rig = context.rig;
  rig.lidars.clear();
  Dataset dataset;
  for (const Drive& drive : context.dataset.drives) {
    dataset.drives.push_back({drive.epoch, drive.imu, {}, drive.cameras});
  }
  CalibrationResult result = *context.result;
  for (const LidarConfig& lidar : context.rig.lidars) {
    result.rejected.push_back({lidar.name, SensorResult::Type::kLidar, lidar.name + ": " + reason});
  }
  CalibrateFromCameras(
      {rig, dataset, context.options, context.cancellation, context.observer, context.store, &result},
      "_without_lidars");
  context.result->stages = result.stages;
  if (!result.Usable()) return false;
  *context.result = std::move(result);
  return true;
}

// The LiDARs first, then the cameras on their trajectory, then all.
void CalibrateFromLidars(const StageContext& context) {
  const auto odometry = OdometryStage(context);
  Initialization start = InitializationStage(context, "", nullptr, [&] {
    return Initialize(context.rig, context.dataset, odometry, context.cancellation);
  });
  CalibrationResult* result = context.result;
  if (start.state.drives.size() < context.dataset.drives.size()) {
    if (CalibrateWithoutLidars(context, start.problems.back())) return;
    result->reasons = start.problems;
    FinishRefused(result);
    return PairStage(context, odometry[0], nullptr);
  }
  result->warnings = start.problems;
  const bool cameras = !context.rig.cameras.empty();
  Adjustment adjustment = StartAt(context, std::move(start));
  if (context.rig.lidars.size() > 1) adjustment = LidarAdjustmentStage(context, std::move(adjustment));
  adjustment = JointAdjustmentStage(context, Landmarks::kNone, !cameras, std::move(adjustment));
  if (cameras && context.options.check_of) {
    adjustment = CheckCameras(context, std::move(adjustment));
  } else if (cameras) {
    std::vector<CameraStart> intrinsics = StartOfCameras(context);
    const auto features = FeatureStage(context, intrinsics, adjustment.state);
    const auto tracks = TrackStage(context, intrinsics, features);
    if (ColmapWanted(context)) ColmapStage(context, AllOf(intrinsics), tracks, &intrinsics);
    CameraInitialization found =
        CameraInitializationStage(context, "cameras", intrinsics, tracks, adjustment.state);
    if (StartLostFromColmap(context, found.found, tracks, &intrinsics)) {
      found = CameraInitializationStage(context, "cameras_from_colmap", intrinsics, tracks, adjustment.state);
    }
    RejectCameras(found, result);
    adjustment = CameraStages(context, intrinsics, found, features, std::move(adjustment));
  }
  HalvesStage(context, &adjustment);
  ResultStage(context, adjustment);
  PairStage(context, odometry[0], &adjustment);
}

}  // namespace

CalibrationResult Calibrate(const Rig& rig, const Dataset& dataset, const CancellationToken& cancellation,
                            CalibrationObserver& observer, StageStore* store,
                            const CalibrationOptions& options) {
  CalibrationResult result;
  result.imu_frame_id = rig.imu.frame_id;
  result.rejected = options.unusable;
  if (rig.lidars.empty() && rig.cameras.empty()) {
    throw InputError(
        "the rig file has no enabled sensor under 'lidars' or 'cameras'; at least one is needed");
  }
  const StageContext context{rig, dataset, options, cancellation, observer, store, &result};
  rig.lidars.empty() ? CalibrateFromCameras(context, "") : CalibrateFromLidars(context);
  const CalibrationResult held = options.held_from ? *options.held_from : HeldSensors(rig);
  if (!held.sensors.empty()) AddSigmasOfHeld(held, &result);
  return result;
}

}  // namespace mlic
