#include "mlic_core/camera/tracks/tracks_from_images.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/camera/tracks/static_mask.h"
#include "mlic_core/camera/two_view/two_view.h"
#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/solver/blas.h"

namespace mlic {
namespace {

// Counts finished parts of parallel work and tells of them.
class Counter {
 public:
  Counter(const Watch& watch, const char* stage, std::size_t count)
      : watch_(watch), stage_(stage), count_(std::max<std::size_t>(1, count)) {}

  void StartPart() const {
    if (watch_.cancellation != nullptr) watch_.cancellation->ThrowIfCancelled();
  }
  void FinishPart() {
    const std::size_t done = ++done_;
    if (watch_.progress != nullptr) watch_.progress->OnProgress(stage_, static_cast<double>(done) / count_);
  }

 private:
  const Watch& watch_;
  const char* stage_;
  std::size_t count_;
  std::atomic<std::size_t> done_{0};
};

// Pixels for each radian at the middle of the image.
double PixelsPerRadian(const CameraIntrinsics& intrinsics) {
  const Eigen::Vector2d centre(0.5 * (intrinsics.width - 1), 0.5 * (intrinsics.height - 1));
  Eigen::Vector3d a, b;
  const bool both = Unproject(intrinsics, centre - Eigen::Vector2d(5.0, 0.0), &a) &&
                    Unproject(intrinsics, centre + Eigen::Vector2d(5.0, 0.0), &b);
  Check(both, "a camera model has no bearing at the middle of its image");
  return 10.0 / std::atan2(a.cross(b).norm(), a.dot(b));
}

std::vector<std::vector<Eigen::Vector3d>> BearingsOf(const std::vector<TrackedCamera>& cameras,
                                                     const ImageFeatures& features) {
  std::vector<std::vector<Eigen::Vector3d>> bearings(features.features.size());
  ParallelFor(bearings.size(), [&](std::size_t k) {
    const CameraIntrinsics& intrinsics = cameras[features.keyframes[k].camera].intrinsics;
    for (const Eigen::Vector2f& pixel : features.features[k].pixels) {
      Eigen::Vector3d bearing;
      if (!Unproject(intrinsics, pixel.cast<double>(), &bearing)) bearing.setZero();
      bearings[k].push_back(bearing);
    }
  });
  return bearings;
}

// Keeps those matches that agree with one geometry of the two views; none where too few do.
std::vector<FeatureMatch> Verify(const std::vector<FeatureMatch>& matches,
                                 const std::vector<Eigen::Vector3d>& bearings_a,
                                 const std::vector<Eigen::Vector3d>& bearings_b, double largest_error,
                                 int fewest) {
  std::vector<FeatureMatch> candidates;
  std::vector<Eigen::Vector3d> a, b;
  for (const FeatureMatch& match : matches) {
    if (bearings_a[match.a].isZero() || bearings_b[match.b].isZero()) continue;
    candidates.push_back(match);
    a.push_back(bearings_a[match.a]);
    b.push_back(bearings_b[match.b]);
  }
  std::vector<FeatureMatch> verified;
  if (static_cast<int>(candidates.size()) < fewest) return verified;
  TwoViewOptions options;
  options.largest_error = largest_error;
  options.fewest_inliers = fewest;
  const auto geometry = EstimateTwoView(a, b, options);
  if (!geometry) return verified;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (geometry->inlier[i]) verified.push_back(candidates[i]);
  }
  return verified;
}

// Predicted poses of all keyframes; nothing if one is missing.
std::optional<std::vector<PredictedView>> PredictViews(const std::vector<TrackedCamera>& cameras,
                                                       const std::vector<Keyframe>& keyframes,
                                                       const CameraPose& predicted_pose) {
  if (!predicted_pose) return std::nullopt;
  std::vector<PredictedView> views;
  for (const Keyframe& keyframe : keyframes) {
    const TrackedCamera& camera = cameras[keyframe.camera];
    const auto pose = predicted_pose(keyframe.camera, keyframe.time + 0.5 * camera.readout);
    if (!pose) return std::nullopt;
    views.push_back({*pose, &camera.intrinsics});
  }
  return views;
}

bool IsSequential(const Keyframe& a, const Keyframe& b, double least_time_apart) {
  return a.camera == b.camera && std::abs(a.time - b.time) < least_time_apart;
}

void Follow(const std::vector<TrackedCamera>& cameras, const std::vector<cv::Mat>& masks,
            const TrackingOptions& options, const Watch& watch, ImageFeatures* result) {
  // Cameras in turn, as each is parallel in itself.
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const auto before = [](const Keyframe& keyframe, int camera) { return keyframe.camera < camera; };
    const auto begin = result->keyframes.begin(), end = result->keyframes.end();
    const auto first = std::lower_bound(begin, end, static_cast<int>(c), before);
    const auto last = std::lower_bound(begin, end, static_cast<int>(c) + 1, before);
    const KeyframeRange range{static_cast<std::size_t>(first - begin),
                              static_cast<std::size_t>(last - begin)};
    const auto matches = FollowFeatures(*cameras[c].recording->images, masks[c], result->keyframes, range,
                                        options.follow, &result->features, watch.cancellation);
    result->followed.insert(result->followed.end(), matches.begin(), matches.end());
    if (watch.progress != nullptr) {
      watch.progress->OnProgress("following", static_cast<double>(c + 1) / cameras.size());
    }
  }
}

}  // namespace

ImageFeatures ExtractFeatures(const std::vector<TrackedCamera>& cameras, const VehiclePose& vehicle_pose,
                              const FeatureMatcher& matcher, const TrackingOptions& options,
                              const Watch& watch) {
  ImageFeatures result;
  std::vector<cv::Mat> masks(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const CameraRecording& recording = *cameras[c].recording;
    const auto keyframes =
        SelectKeyframes(recording, static_cast<int>(c), vehicle_pose, options.keyframes, watch.cancellation);
    masks[c] = FindStaticPixels(recording, keyframes, options.static_mask, watch.cancellation);
    result.keyframes.insert(result.keyframes.end(), keyframes.begin(), keyframes.end());
  }
  result.features.resize(result.keyframes.size());
  Counter counter(watch, "features", result.keyframes.size());
  ParallelFor(result.keyframes.size(), [&](std::size_t k) {
    counter.StartPart();
    const Keyframe& keyframe = result.keyframes[k];
    const cv::Mat gray = ToGray(cameras[keyframe.camera].recording->images->Load(keyframe.image));
    result.features[k] = matcher.Detect(gray, masks[keyframe.camera]);
    counter.FinishPart();
  });
  if (options.follow.enabled) Follow(cameras, masks, options, watch, &result);
  return result;
}

std::vector<ImagePair> ChoosePairs(const std::vector<TrackedCamera>& cameras,
                                   const std::vector<Keyframe>& keyframes, const CameraPose& predicted_pose,
                                   const TrackingOptions& options) {
  const std::vector<ImagePair> sequential = SequentialPairs(keyframes, options.sequential);
  const auto views = PredictViews(cameras, keyframes, predicted_pose);
  if (!views) return sequential;
  return UnitePairs(sequential, PredictedPairs(keyframes, *views, options.predicted));
}

std::vector<PairMatches> MatchPairs(const std::vector<TrackedCamera>& cameras, const ImageFeatures& features,
                                    const std::vector<ImagePair>& pairs, const CameraPose& predicted_pose,
                                    const FeatureMatcher& matcher, const TrackingOptions& options,
                                    const Watch& watch) {
  const auto bearings = BearingsOf(cameras, features);
  const auto views = PredictViews(cameras, features.keyframes, predicted_pose);
  std::vector<PairMatches> all(pairs.size() + features.followed.size());
  Counter counter(watch, "matching", all.size());
  const auto verify = [&](std::int32_t a, std::int32_t b, const std::vector<FeatureMatch>& matches) {
    const double focal = std::min(PixelsPerRadian(cameras[features.keyframes[a].camera].intrinsics),
                                  PixelsPerRadian(cameras[features.keyframes[b].camera].intrinsics));
    return PairMatches{a, b,
                       Verify(matches, bearings[a], bearings[b], options.largest_epipolar_error / focal,
                              options.fewest_matches)};
  };
  const BlasOnOneThread one_thread;
  ParallelFor(all.size(), [&](std::size_t p) {
    counter.StartPart();
    if (p >= pairs.size()) {
      const PairMatches& followed = features.followed[p - pairs.size()];
      all[p] = verify(followed.keyframe_a, followed.keyframe_b, followed.matches);
      counter.FinishPart();
      return;
    }
    const ImagePair& pair = pairs[p];
    const Keyframe &a = features.keyframes[pair.a], &b = features.keyframes[pair.b];
    MatchGuide guide;
    const MatchGuide* given = nullptr;
    if (views && !IsSequential(a, b, options.predicted.least_time_apart)) {
      const RigidTransform T_b_a = (*views)[pair.b].T_map_camera.Inverse() * (*views)[pair.a].T_map_camera;
      if (T_b_a.translation.norm() > options.least_baseline) {
        guide.R_b_a = T_b_a.rotation.toRotationMatrix();
        guide.t_b_a = T_b_a.translation.normalized();
        guide.largest_error = options.prediction_error;
        guide.bearings_a = &bearings[pair.a];
        guide.bearings_b = &bearings[pair.b];
        given = &guide;
      }
    }
    const auto matches = matcher.Match(features.features[pair.a], features.features[pair.b], given);
    all[p] = verify(pair.a, pair.b, matches);
    counter.FinishPart();
  });
  const auto empty = [](const PairMatches& pair) { return pair.matches.empty(); };
  all.erase(std::remove_if(all.begin(), all.end(), empty), all.end());
  return all;
}

TrackSet TracksFromMatches(const std::vector<TrackedCamera>& cameras, const ImageFeatures& features,
                           const std::vector<PairMatches>& matches, const CameraPose& predicted_pose,
                           const TrackingOptions& options, const Watch& watch) {
  std::vector<std::size_t> counts;
  std::vector<std::pair<int, int>> sizes;
  for (std::size_t k = 0; k < features.keyframes.size(); ++k) {
    const CameraRecording& recording = *cameras[features.keyframes[k].camera].recording;
    counts.push_back(features.features[k].Count());
    sizes.emplace_back(recording.width, recording.height);
  }
  const auto joined = JoinMatches(counts, matches);
  const TrackSet all = TracksOfFeatures(features.keyframes, features.features, joined);
  TrackSet selected;
  selected.keyframes = features.keyframes;
  std::vector<FeatureTrack> selected_features;
  for (const std::size_t t : SelectTracks(all, sizes, options.selection)) {
    selected.tracks.push_back(all.tracks[t]);
    selected_features.push_back(joined[t]);
  }
  std::vector<const ImageSource*> images;
  for (const TrackedCamera& camera : cameras) images.push_back(camera.recording->images.get());
  ViewOfRow view;
  if (predicted_pose) {
    view = [&](const Keyframe& keyframe, double row) -> std::optional<PredictedView> {
      const TrackedCamera& camera = cameras[keyframe.camera];
      const double delay = row / camera.intrinsics.height * camera.readout;
      const auto pose = predicted_pose(keyframe.camera, keyframe.time + delay);
      if (!pose) return std::nullopt;
      return PredictedView{*pose, &camera.intrinsics};
    };
  }
  return RefineTracks(selected, selected_features, features.features, images, view, options.refinement,
                      watch.cancellation);
}

TrackSet FindTracks(const std::vector<TrackedCamera>& cameras, const VehiclePose& vehicle_pose,
                    const CameraPose& predicted_pose, const FeatureMatcher& matcher,
                    const TrackingOptions& options, const Watch& watch) {
  const ImageFeatures features = ExtractFeatures(cameras, vehicle_pose, matcher, options, watch);
  const auto pairs = ChoosePairs(cameras, features.keyframes, predicted_pose, options);
  const auto matches = MatchPairs(cameras, features, pairs, predicted_pose, matcher, options, watch);
  return TracksFromMatches(cameras, features, matches, predicted_pose, options, watch);
}

}  // namespace mlic
