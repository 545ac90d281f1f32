#include "mlic_core/pipeline/pair_cameras.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "mlic_core/pipeline/adjustment_context.h"
#include "mlic_core/pipeline/camera_placement.h"
#include "mlic_core/pipeline/camera_stages.h"
#include "mlic_core/pipeline/joint_adjustment.h"
#include "mlic_core/summary/map_projections.h"
#include "mlic_core/summary/pair_assembly.h"

namespace mlic {
namespace {

// Of the first round's observations of tracks: the cameras are placed to some pixels.
constexpr double kFirstNoise = 8.0;  // from: guard, later rounds measure it

// Whether any of its matches with the map took part.
bool IsMatched(const LandmarkSet& landmarks, std::size_t camera) {
  for (std::size_t p = 0; p < landmarks.points.size(); ++p) {
    if (landmarks.IsOnMap(p) &&
        landmarks.observations[landmarks.begin[p]].camera == static_cast<int>(camera)) {
      return true;
    }
  }
  return false;
}

// Leaves the cameras that have a place and are not known yet, so that the others take no part in anything.
std::vector<CameraPlace> KeepPlaced(const std::vector<PlacedCamera>& places, const std::vector<bool>& known,
                                    LidarsAlone* alone, std::vector<CameraStart>* starts) {
  Drive& drive = alone->dataset.drives[0];
  const std::size_t lidars = alone->rig.lidars.size();
  std::vector<CameraConfig> configs;
  std::vector<CameraRecording> recordings;
  std::vector<CameraStart> kept_starts;
  std::vector<CameraPlace> placed;
  std::vector<double> sigmas(alone->time_offset_sigmas.begin(),
                             alone->time_offset_sigmas.begin() + static_cast<std::ptrdiff_t>(lidars));
  for (std::size_t c = 0; c < places.size(); ++c) {
    if (known[c] || !places[c].problem.empty()) continue;
    placed.push_back(places[c].place);
    configs.push_back(alone->rig.cameras[c]);
    recordings.push_back(drive.cameras[c]);
    kept_starts.push_back((*starts)[c]);
    sigmas.push_back(alone->time_offset_sigmas[lidars + c]);
  }
  alone->rig.cameras = std::move(configs);
  drive.cameras = std::move(recordings);
  alone->time_offset_sigmas = std::move(sigmas);
  *starts = std::move(kept_starts);
  return placed;
}

PoseSigma SigmaOf(const CameraPlace& place, double time_offset) {
  PoseSigma sigma;
  sigma.rotation = place.claimed.diagonal().head<3>().cwiseSqrt();
  sigma.translation = place.claimed.diagonal().tail<3>().cwiseSqrt();
  sigma.time_offset = time_offset;
  return sigma;
}

// The cameras of a parked vehicle, or those without a place, on what the LiDARs see.
std::vector<CameraProjection> DrawPlaced(const LidarsAlone& alone, const std::vector<CameraStart>& starts,
                                         const std::vector<PlacedCamera>& places, Adjustment lidars) {
  for (std::size_t c = 0; c < places.size(); ++c) {
    CameraCalibration camera = CameraAsGiven(alone.rig.cameras[c], starts[c]);
    lidars.map.cameras_before.push_back(camera);
    const bool found = places[c].problem.empty();
    if (found) camera.sensor.T_imu_sensor = places[c].place.T_root_camera;
    lidars.state.cameras.push_back(camera);
    lidars.cameras.found.push_back(found);
  }
  std::vector<CameraProjection> drawn;
  for (std::size_t c = 0; c < places.size(); ++c) {
    if (lidars.cameras.found[c] && !alone.parked) continue;
    auto projection = ProjectOnPhoto(alone.rig, alone.dataset, lidars, c);
    if (projection) drawn.push_back(std::move(*projection));
  }
  return drawn;
}

// The cameras where they were placed, with what the rig file says of them.
CameraInitialization StartOf(const LidarsAlone& alone, const std::vector<CameraStart>& starts,
                             const std::vector<CameraPlace>& places) {
  CameraInitialization cameras;
  for (std::size_t c = 0; c < places.size(); ++c) {
    CameraCalibration camera = CameraAsGiven(alone.rig.cameras[c], starts[c]);
    camera.sensor.T_imu_sensor = places[c].T_root_camera;
    cameras.cameras.push_back(camera);
    FixedCameraParameters held;
    held.time_offset = true;  // at constant speed it looks like a move along the way
    held.intrinsics.assign(camera.intrinsics.parameters.size(), true);  // until a solve shows them
    cameras.held.push_back(held);
    cameras.noise.push_back({kFirstNoise, 1.0});
  }
  cameras.found.assign(places.size(), true);
  return cameras;
}

// context: about the root, as alone.
Adjustment AdjustWithCameras(const StageContext& context, const LidarsAlone& alone,
                             const std::vector<CameraStart>& starts, const std::vector<CameraPlace>& places,
                             Adjustment adjustment) {
  const CameraInitialization cameras = StartOf(alone, starts, places);
  CalibrationState state = adjustment.state;
  state.cameras = cameras.cameras;
  const auto features = FeatureStage(context, starts, state);
  const auto tracks = SharedTrackStage(context, SharedPass::kAll, state, features);
  StageClock stage("cameras about the root", context);
  AddCameras(alone.rig, cameras, tracks, &adjustment);
  for (std::size_t c = 0; c < places.size(); ++c) {
    adjustment.cameras.always_fixed[c].time_offset = true;
    adjustment.cameras.sigmas.push_back(
        SigmaOf(places[c], alone.time_offset_sigmas[alone.rig.lidars.size() + c]));
  }
  const AdjustmentContext of_stage = ContextOf(context, &stage);
  JointOptions options;
  options.landmarks = Landmarks::kTracksAndMap;
  options.find_sensor_errors = false;
  adjustment = AdjustJointly(std::move(adjustment), of_stage, options);
  MeasureUncertainty(of_stage, &adjustment);
  return adjustment;
}

// Why what the rounds ended with cannot be given; empty: it can.
std::string ProblemOf(const Adjustment& adjustment, std::size_t camera, const std::string& name) {
  if (!IsMatched(adjustment.problem.drives[0].landmarks, camera)) {
    return name +
           ": its photos do not match the LiDARs' map; check intrinsics and stamps, or turn it to what "
           "the LiDARs see";
  }
  if (!(adjustment.rounds.last_change < kLargestChangeOfPairs)) {
    return name +
           ": its place against the LiDARs has not converged; record a longer drive among more structure";
  }
  return "";
}

// Of the pairs, or of those that are in none.
bool IsIn(const std::string& camera, const PairedCameras& paired) {
  const auto has = [&](const PairResult& pair) { return Has(pair, camera); };
  const auto named = [&](const SensorProblem& problem) { return problem.sensor == camera; };
  return std::any_of(paired.pairs.begin(), paired.pairs.end(), has) ||
         std::any_of(paired.problems.begin(), paired.problems.end(), named);
}

void TakeOut(const std::string& camera, const std::string& problem, PairedCameras* paired) {
  std::vector<PairResult>& pairs = paired->pairs;
  pairs.erase(
      std::remove_if(pairs.begin(), pairs.end(), [&](const PairResult& pair) { return Has(pair, camera); }),
      pairs.end());
  paired->problems.push_back({camera, problem});
}

// Where the calibration with the IMU has a camera against the root, if its photos matched the map there.
std::optional<CameraPlace> PlaceIn(const Adjustment& whole, const ObservabilityAnalysis& analysis,
                                   std::size_t root, std::size_t camera) {
  if (whole.rejected_lidars[root] || !whole.cameras.found[camera] ||
      !IsMatched(whole.problem.drives[0].landmarks, camera)) {
    return std::nullopt;
  }
  const SensorCalibration& lidar = whole.state.lidars[root];
  const SensorCalibration& sensor = whole.state.cameras[camera].sensor;
  const std::size_t place = whole.state.Sensors().PlaceOf(CameraId(camera));
  const auto covariance = PairCovariance(lidar, sensor, JointCovariance(analysis.covariance, root, place));
  return CameraPlace{lidar.T_imu_sensor.Inverse() * sensor.T_imu_sensor, covariance.topLeftCorner<6, 6>(),
                     covariance.topLeftCorner<6, 6>()};
}

// The cameras that the calibration with the IMU has in the map, with the lenses that it found.
std::vector<std::optional<CameraPlace>> PlacesIn(const StageContext& context, const Adjustment* whole,
                                                 std::size_t root, std::vector<CameraStart>* starts) {
  std::vector<std::optional<CameraPlace>> places(starts->size());
  if (whole == nullptr || whole->cameras.found.empty()) return places;
  const ObservabilityAnalysis analysis = Analyze(*whole, context.dataset);
  for (std::size_t c = 0; c < places.size(); ++c) {
    places[c] = PlaceIn(*whole, analysis, root, c);
    if (!places[c]) continue;
    const CameraCalibration& camera = whole->state.cameras[c];
    (*starts)[c] = {camera.intrinsics, false, camera.readout};
  }
  return places;
}

// The known pair of the root and a camera.
std::optional<CameraPlace> PlaceIn(const std::vector<PairResult>& known, const std::string& root,
                                   const std::string& camera) {
  for (const PairResult& pair : known) {
    if (pair.a != root || pair.b != camera) continue;
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << pair.sigma.rotation, pair.sigma.translation;
    const Eigen::Matrix<double, 6, 6> covariance = sigma.cwiseAbs2().asDiagonal();
    return CameraPlace{pair.T_a_b, covariance, covariance};
  }
  return std::nullopt;
}

// Places the cameras; those without a place and those that are known are left out of everything that follows.
std::vector<CameraPlace> PlaceStage(const StageContext& context, const Adjustment* whole,
                                    const std::vector<PairResult>& known, LidarsAlone* alone,
                                    std::vector<CameraStart>* starts, const Adjustment& lidars,
                                    PairedCameras* paired) {
  StageClock stage("places of cameras in the map", context);
  auto given = PlacesIn(context, whole, alone->root, starts);
  std::vector<bool> is_known;
  for (std::size_t c = 0; c < given.size(); ++c) {
    const auto place = PlaceIn(known, alone->rig.lidars[alone->root].name, alone->rig.cameras[c].name);
    is_known.push_back(place.has_value());
    if (place) given[c] = place;
  }
  const std::vector<PlacedCamera> places =
      PlaceCameras(*alone, *starts, given, lidars.state, context.cancellation);
  for (std::size_t c = 0; c < places.size(); ++c) {
    const std::string& name = alone->rig.cameras[c].name;
    if (!places[c].problem.empty()) {
      stage.Line(places[c].problem);
      paired->problems.push_back({name, places[c].problem});
      continue;
    }
    const PoseSigma sigma = SigmaOf(places[c].place, 0.0);
    char line[200];
    std::snprintf(line, sizeof(line), "%s: %s to %.2f deg and %.0f mm", name.c_str(),
                  is_known[c] ? "known by the calibration with the IMU" : "placed",
                  sigma.rotation.maxCoeff() * 180.0 / M_PI, 1e3 * sigma.translation.maxCoeff());
    stage.Line(line);
  }
  paired->projections = DrawPlaced(*alone, *starts, places, lidars);
  return KeepPlaced(places, is_known, alone, starts);
}

}  // namespace

PairedCameras PairCameras(const StageContext& context, const Adjustment* whole,
                          const std::vector<PairResult>& known, Adjustment adjustment,
                          LidarsAlone* about_root) {
  LidarsAlone& alone = *about_root;
  PairedCameras paired;
  std::vector<CameraStart> starts = StartFromRig(alone.rig, alone.dataset);
  for (std::size_t l = 0; l < alone.tied.size(); ++l) {
    if (!alone.tied[l]) alone.dataset.drives[0].lidars[l].scans.clear();  // the map has no place for them
  }
  const std::vector<CameraPlace> places =
      PlaceStage(context, whole, known, &alone, &starts, adjustment, &paired);
  if (places.empty()) return paired;
  if (alone.parked) {
    for (std::size_t c = 0; c < places.size(); ++c) {
      const auto pair = MakeStillPair(alone, c, places[c]);
      if (pair) paired.pairs.push_back(*pair);
    }
  } else {
    const StageContext about{alone.rig,        alone.dataset, context.options, context.cancellation,
                             context.observer, nullptr,       context.result};
    adjustment = AdjustWithCameras(about, alone, starts, places, std::move(adjustment));
    paired.pairs = MakeCameraPairs(alone, adjustment);
    for (std::size_t c = 0; c < places.size(); ++c) {
      const std::string problem = ProblemOf(adjustment, c, alone.rig.cameras[c].name);
      if (!problem.empty()) TakeOut(alone.rig.cameras[c].name, problem, &paired);
      auto projection = ProjectOnPhoto(alone.rig, alone.dataset, adjustment, c);
      if (projection) paired.projections.push_back(std::move(*projection));
    }
  }
  for (const CameraConfig& camera : alone.rig.cameras) {
    const std::string& name = camera.name;
    if (IsIn(name, paired)) continue;
    TakeOut(name,
            name +
                ": its place against the LiDARs is known to no better than 2 deg and 0.3 m; record a "
                "longer drive, or where it sees more of what the LiDARs see",
            &paired);
  }
  return paired;
}

}  // namespace mlic
