#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/camera/features/features.h"
#include "mlic_core/camera/tracks/feature_tracking.h"
#include "mlic_core/camera/tracks/image_pairs.h"
#include "mlic_core/camera/tracks/keyframes.h"
#include "mlic_core/camera/tracks/refinement.h"
#include "mlic_core/camera/tracks/static_mask.h"
#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/camera/two_view/two_view.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/sensors/camera_model.h"
#include "mlic_core/sensors/images.h"

namespace mlic {

// One camera: what it recorded and its intrinsics as far as known. Both outlive the calls.
struct TrackedCamera {
  const CameraRecording* recording = nullptr;
  CameraIntrinsics intrinsics;
  double readout = 0.0;  // s, as far as known; 0 for global shutters
};

// Predicted T_map_camera at a time of the camera's clock; nothing where not known.
using CameraPose = std::function<std::optional<RigidTransform>(int camera, double time)>;

struct TrackingOptions {
  KeyframeOptions keyframes;
  StaticMaskOptions static_mask;
  FollowOptions follow;
  SequentialPairOptions sequential;
  PredictedPairOptions predicted;
  // Largest epipolar error of a match, px at the image's centre. With intrinsics from the field of view alone
  // the model itself is off by some pixels; with calibrated ones 2 px are right.
  double largest_epipolar_error = 6.0;
  // Predictions: their relative rotation and direction of translation are this good (rad); where predicted
  // cameras are nearer to each other than least_baseline (m), the direction is not used.
  double prediction_error = 0.06;
  double least_baseline = 0.5;
  int fewest_matches = TwoViewOptions().fewest_inliers;  // of a pair that counts
  TrackSelectionOptions selection;
  TrackRefinementOptions refinement;
};

// Keyframes and their features, ordered as TrackSet::keyframes.
struct ImageFeatures {
  std::vector<Keyframe> keyframes;
  std::vector<FeatureSet> features;
  std::vector<PairMatches> followed;  // of consecutive keyframes, through the images between; not verified
};

// What long work is watched and stopped by; both may be null.
struct Watch {
  ProgressSink* progress = nullptr;
  const CancellationToken* cancellation = nullptr;
};

// Keyframes of all cameras, their own body masked, and the features in them. Images are read one at a time
// for each thread. vehicle_pose: may be empty.
ImageFeatures ExtractFeatures(const std::vector<TrackedCamera>& cameras, const VehiclePose& vehicle_pose,
                              const FeatureMatcher& matcher, const TrackingOptions& options,
                              const Watch& watch);

// Sequential pairs, and where poses are predicted for all keyframes, pairs that share their view.
std::vector<ImagePair> ChoosePairs(const std::vector<TrackedCamera>& cameras,
                                   const std::vector<Keyframe>& keyframes, const CameraPose& predicted_pose,
                                   const TrackingOptions& options);

// Matches of each pair that agree with one geometry of two views; pairs with too few are left out. Pairs with
// predicted poses are matched near their epipolar lines only (sequential ones always freely).
std::vector<PairMatches> MatchPairs(const std::vector<TrackedCamera>& cameras, const ImageFeatures& features,
                                    const std::vector<ImagePair>& pairs, const CameraPose& predicted_pose,
                                    const FeatureMatcher& matcher, const TrackingOptions& options,
                                    const Watch& watch);

// From matches to refined and selected tracks.
TrackSet TracksFromMatches(const std::vector<TrackedCamera>& cameras, const ImageFeatures& features,
                           const std::vector<PairMatches>& matches, const CameraPose& predicted_pose,
                           const TrackingOptions& options, const Watch& watch);

// All of the above. vehicle_pose and predicted_pose may be empty.
TrackSet FindTracks(const std::vector<TrackedCamera>& cameras, const VehiclePose& vehicle_pose,
                    const CameraPose& predicted_pose, const FeatureMatcher& matcher,
                    const TrackingOptions& options, const Watch& watch = {});

}  // namespace mlic
