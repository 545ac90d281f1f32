#include "mlic_core/pipeline/camera_stages.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "mlic_core/pipeline/stage_names.h"

namespace mlic {
namespace {

std::string OfDrive(const std::string& name, std::size_t drive) {
  return name + "_" + std::to_string(drive + 1);
}

const FeatureMatcher& Matcher(const CalibrationOptions& options) {
  static const std::unique_ptr<FeatureMatcher> kClassical = MakeClassicalMatcher();
  return options.matcher ? *options.matcher : *kClassical;
}

std::vector<TrackedCamera> Cameras(const Drive& drive, const std::vector<CameraIntrinsics>& intrinsics) {
  std::vector<TrackedCamera> cameras;
  for (std::size_t c = 0; c < drive.cameras.size(); ++c) {
    cameras.push_back({&drive.cameras[c], intrinsics[c], 0.0});
  }
  return cameras;
}

std::vector<CameraIntrinsics> Intrinsics(const std::vector<CameraStart>& start) {
  std::vector<CameraIntrinsics> intrinsics;
  for (const CameraStart& camera : start) intrinsics.push_back(camera.intrinsics);
  return intrinsics;
}

// What `make` gives for every drive, or what an earlier run kept.
template <typename T, typename Make>
std::vector<T> ForEveryDrive(const StageContext& context, const std::string& name, StageClock* stage,
                             const Make& make) {
  std::vector<T> of_drives(context.dataset.drives.size());
  for (std::size_t d = 0; d < of_drives.size(); ++d) {
    if (context.Load(OfDrive(name, d), &of_drives[d])) {
      stage->TakeOver(stage->lines());
    } else {
      of_drives[d] = make(d);
      context.Save(OfDrive(name, d), of_drives[d]);
    }
  }
  return of_drives;
}

void CountTracks(const StageContext& context, const std::vector<TrackSet>& tracks, StageClock* stage) {
  for (std::size_t c = 0; c < context.rig.cameras.size(); ++c) {
    std::size_t keyframes = 0, observations = 0, shared = 0;
    for (const TrackSet& set : tracks) {
      const auto camera = [&](const TrackObservation& o) {
        return static_cast<std::size_t>(set.keyframes[o.keyframe].camera);
      };
      for (const Keyframe& keyframe : set.keyframes)
        keyframes += static_cast<std::size_t>(keyframe.camera) == c;
      for (const Track& track : set.tracks) {
        std::size_t own = 0;
        for (const TrackObservation& o : track.observations) own += camera(o) == c;
        observations += own;
        if (own < track.observations.size()) shared += own;
      }
    }
    char line[200];
    std::snprintf(line, sizeof(line),
                  "%s: %zu keyframes, %zu observations of tracks, %zu of them shared with other cameras",
                  context.rig.cameras[c].name.c_str(), keyframes, observations, shared);
    stage->Line(line);
    for (const Drive& drive : context.dataset.drives) {
      const std::size_t undecodable = drive.cameras[c].images->Undecodable();
      if (undecodable == 0) continue;
      stage->Line(context.rig.cameras[c].name + ": " + std::to_string(undecodable) +
                  " images cannot be decoded and count as black; check the recording's disk and the driver");
    }
  }
}

struct PassNames {
  const char *tracks, *tracks_file, *cameras, *cameras_file;
};

PassNames Names(SharedPass pass) {
  if (pass == SharedPass::kFirstLook) {
    return {stage_names::kFirstSharedTracks, "first_shared_tracks", stage_names::kFirstSharedCameras,
            "first_cameras_shared"};
  }
  return {stage_names::kSharedTracks, "shared_tracks", stage_names::kSharedCameras, "cameras_shared"};
}

TrackingOptions OptionsOf(const StageContext& context) {
  // Of a check, of all cameras together, and of one at least. from: measured, stereo rig: half a minute
  constexpr int kMostOfAll = 70, kLeastOfOne = 12;
  TrackingOptions options;
  if (context.options.check_of) {
    const int cameras = static_cast<int>(context.rig.cameras.size());
    options.keyframes.most_keyframes = std::max(kLeastOfOne, kMostOfAll / cameras);
  }
  return options;
}

// Every second keyframe of the cameras that have many.
ImageFeatures Thinned(const ImageFeatures& all) {
  constexpr int kMany = 40;  // from: guard, time
  std::map<int, int> counts, seen;
  for (const Keyframe& keyframe : all.keyframes) ++counts[keyframe.camera];
  ImageFeatures thinned;
  for (std::size_t k = 0; k < all.keyframes.size(); ++k) {
    const int camera = all.keyframes[k].camera;
    if (seen[camera]++ % 2 == 1 && counts[camera] >= kMany) continue;
    thinned.keyframes.push_back(all.keyframes[k]);
    thinned.features.push_back(all.features[k]);
  }
  return thinned;
}

}  // namespace

std::vector<ImageFeatures> FeatureStage(const StageContext& context, const std::vector<CameraStart>& start,
                                        const CalibrationState& state) {
  StageClock stage(stage_names::kFeatures, context);
  stage.Line("matcher: " + Matcher(context.options).Name());
  const Watch watch{&stage, &context.cancellation};
  return ForEveryDrive<ImageFeatures>(context, "features", &stage, [&](std::size_t d) {
    VehiclePose pose;
    if (d < state.drives.size()) {
      const SplitSpline& trajectory = state.drives[d].trajectory;
      pose = [&trajectory](double t) -> std::optional<RigidTransform> {
        if (!trajectory.Contains(t)) return std::nullopt;
        return trajectory.Pose(t);
      };
    }
    return ExtractFeatures(Cameras(context.dataset.drives[d], Intrinsics(start)), pose,
                           Matcher(context.options), OptionsOf(context), watch);
  });
}

std::vector<TrackSet> TrackStage(const StageContext& context, const std::vector<CameraStart>& start,
                                 const std::vector<ImageFeatures>& features) {
  StageClock stage(stage_names::kTracks, context);
  const Watch watch{&stage, &context.cancellation};
  const TrackingOptions options = OptionsOf(context);
  const auto tracks = ForEveryDrive<TrackSet>(context, "tracks", &stage, [&](std::size_t d) {
    const auto cameras = Cameras(context.dataset.drives[d], Intrinsics(start));
    const auto pairs = ChoosePairs(cameras, features[d].keyframes, {}, options);
    const auto matches =
        MatchPairs(cameras, features[d], pairs, {}, Matcher(context.options), options, watch);
    return TracksFromMatches(cameras, features[d], matches, {}, options, watch);
  });
  CountTracks(context, tracks, &stage);
  return tracks;
}

std::vector<TrackSet> SharedTrackStage(const StageContext& context, SharedPass pass,
                                       const CalibrationState& state,
                                       const std::vector<ImageFeatures>& all_features) {
  StageClock stage(Names(pass).tracks, context);
  const Watch watch{&stage, &context.cancellation};
  TrackingOptions options = OptionsOf(context);
  options.largest_epipolar_error = 2.0;
  options.prediction_error = 0.02;
  options.selection.most_in_keyframe = 450;  // most do not survive their refinement
  std::vector<CameraIntrinsics> intrinsics;
  for (const CameraCalibration& camera : state.cameras) intrinsics.push_back(camera.intrinsics);
  const auto tracks = ForEveryDrive<TrackSet>(context, Names(pass).tracks_file, &stage, [&](std::size_t d) {
    ImageFeatures thinned;
    if (pass == SharedPass::kFirstLook) thinned = Thinned(all_features[d]);
    const ImageFeatures& features = pass == SharedPass::kFirstLook ? thinned : all_features[d];
    auto cameras = Cameras(context.dataset.drives[d], intrinsics);
    for (std::size_t c = 0; c < cameras.size(); ++c) cameras[c].readout = state.cameras[c].readout;
    const SplitSpline& trajectory = state.drives[d].trajectory;
    const CameraPose pose = [&](int camera, double time) -> std::optional<RigidTransform> {
      const SensorCalibration& sensor = state.cameras[camera].sensor;
      // A keyframe a little outside the span is predicted from its end.
      const double t =
          std::clamp(sensor.OnImuClock(time, trajectory.Middle()), trajectory.Start(), trajectory.End());
      return trajectory.Pose(t) * sensor.T_imu_sensor;
    };
    const auto pairs = ChoosePairs(cameras, features.keyframes, pose, options);
    const auto matches = MatchPairs(cameras, features, pairs, pose, Matcher(context.options), options, watch);
    return TracksFromMatches(cameras, features, matches, pose, options, watch);
  });
  CountTracks(context, tracks, &stage);
  return tracks;
}

CameraInitialization CameraInitializationStage(const StageContext& context, const std::string& file,
                                               const std::vector<CameraStart>& start,
                                               const std::vector<TrackSet>& tracks,
                                               const CalibrationState& state) {
  StageClock stage(stage_names::kCameras, context);
  CameraInitialization cameras;
  if (context.Load(file, &cameras)) {
    stage.TakeOver({});
  } else {
    cameras = InitializeCameras(context.rig, start, tracks, state, context.cancellation);
    context.Save(file, cameras);
  }
  for (const std::string& note : cameras.notes) stage.Line(note);
  for (const SensorProblem& problem : cameras.problems) stage.Line(problem.reason);
  return cameras;
}

void SharedCameraStage(const StageContext& context, SharedPass pass, const std::vector<CameraStart>& start,
                       const std::vector<TrackSet>& shared_tracks, const CalibrationState& state,
                       CameraInitialization* found) {
  StageClock stage(Names(pass).cameras, context);
  if (context.Load(Names(pass).cameras_file, found)) {
    stage.TakeOver({});
  } else {
    found->notes.clear();
    found->problems.clear();
    AdjustCamerasFurther(context.rig, start, shared_tracks, state, context.cancellation, found);
    context.Save(Names(pass).cameras_file, *found);
  }
  for (const std::string& note : found->notes) stage.Line(note);
  for (const SensorProblem& problem : found->problems) stage.Line(problem.reason);
}

}  // namespace mlic
