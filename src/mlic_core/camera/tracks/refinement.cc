#include "mlic_core/camera/tracks/refinement.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/camera/tracks/patch.h"
#include "mlic_core/camera/tracks/patch_surface.h"
#include "mlic_core/camera/two_view/triangulation.h"
#include "mlic_core/common/error.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

constexpr int kLevels = 6;  // from: structural

// The warp from patch to patch that the features' own scales and angles give.
Eigen::Matrix2f WarpOfFeatures(const FeatureSet& a, int feature_a, int level_a, const FeatureSet& b,
                               int feature_b, int level_b) {
  const float scale_a = a.scales[feature_a] / static_cast<float>(1 << level_a);
  const float scale_b = b.scales[feature_b] / static_cast<float>(1 << level_b);
  const float angle = b.angles[feature_b] - a.angles[feature_a];
  Eigen::Matrix2f rotation;
  rotation << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return (scale_b / scale_a) * rotation;
}

class Refinement {
 public:
  Refinement(const TrackSet& tracks, const std::vector<FeatureTrack>& feature_tracks,
             const std::vector<FeatureSet>& features, const ViewOfRow& view,
             const TrackRefinementOptions& options)
      : tracks_(tracks),
        feature_tracks_(feature_tracks),
        features_(features),
        view_(view),
        options_(options) {
    patches_.resize(tracks.tracks.size());
    of_keyframe_.resize(tracks.keyframes.size());
    for (std::size_t t = 0; t < tracks.tracks.size(); ++t) {
      Check(feature_tracks[t].size() == tracks.tracks[t].observations.size(),
            "RefineTracks: one feature for each observation");
      patches_[t].resize(feature_tracks[t].size());
      for (std::size_t i = 0; i < feature_tracks[t].size(); ++i) {
        of_keyframe_[feature_tracks[t][i].keyframe].emplace_back(t, i);
      }
    }
  }

  bool Uses(std::size_t keyframe) const { return !of_keyframe_[keyframe].empty(); }

  void CutPatches(std::size_t keyframe, const cv::Mat& gray) {
    const std::vector<cv::Mat> pyramid = AreaPyramid(gray, kLevels);
    const FeatureSet& features = features_[keyframe];
    for (const auto& [t, i] : of_keyframe_[keyframe]) {
      const int feature = feature_tracks_[t][i].feature;
      const int level = LevelOfScale(features.scales[feature], static_cast<int>(pyramid.size()));
      patches_[t][i] = CutPatch(pyramid, features.pixels[feature], level);
    }
  }

  Track Refine(std::size_t t) const {
    Track refined;
    const auto& observations = tracks_.tracks[t].observations;
    // The middle of the track differs least from its ends.
    const std::size_t reference = observations.size() / 2;
    const auto fixed = PatchTemplate::Make(patches_[t][reference], options_.radius);
    std::vector<std::optional<PatchAlignment>> alignments(observations.size());
    for (std::size_t i = 0; i < observations.size() && fixed; ++i) {
      if (i == reference) continue;
      alignments[i] = fixed->Align(patches_[t][i], patches_[t][i].feature, Warp(t, reference, i));
    }
    if (fixed && view_) Bend(t, reference, *fixed, &alignments);
    std::vector<float> sigmas;
    std::size_t place_of_reference = 0;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      if (i == reference) {
        place_of_reference = refined.observations.size();
        refined.observations.push_back(observations[i]);
        continue;
      }
      TrackObservation observation = observations[i];
      if (!alignments[i] || !Accept(t, reference, i, *alignments[i], &observation)) continue;
      sigmas.push_back(observation.sigma);
      refined.observations.push_back(observation);
    }
    if (!sigmas.empty()) {
      refined.observations[place_of_reference].sigma = Median(std::move(sigmas));
    }
    return refined;
  }

 private:
  // The affine part that the features' own scales and angles give.
  Eigen::Matrix2f Warp(std::size_t t, std::size_t reference, std::size_t i) const {
    const FeatureReference &a = feature_tracks_[t][reference], &b = feature_tracks_[t][i];
    return WarpOfFeatures(features_[a.keyframe], a.feature, patches_[t][reference].level,
                          features_[b.keyframe], b.feature, patches_[t][i].level);
  }

  // While the row with the feature is exposed.
  std::optional<PredictedView> View(std::size_t t, std::size_t i) const {
    const TrackObservation& o = tracks_.tracks[t].observations[i];
    return view_(tracks_.keyframes[o.keyframe], o.pixel.y());
  }
  Eigen::Vector2d Pixel(std::size_t t, std::size_t i, const Eigen::Vector2f& in_patch) const {
    const Patch& patch = patches_[t][i];
    return FromLevel(in_patch + patch.corner.cast<float>(), patch.level).cast<double>();
  }

  // Aligns again with the bend that the piece of surface has in each view, where it can be told.
  void Bend(std::size_t t, std::size_t reference, const PatchTemplate& fixed,
            std::vector<std::optional<PatchAlignment>>* alignments) const {
    std::vector<std::optional<PredictedView>> views(alignments->size());
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (i == reference || (*alignments)[i]) views[i] = View(t, i);
    }
    if (!views[reference]) return;
    const auto middle = Eigen::Vector2f::Constant(static_cast<float>(Patch::kHalf));
    const auto point = Triangulate(t, reference, *alignments, views);
    if (!point) return;
    auto piece = SurfacePiece::Make(*views[reference], Pixel(t, reference, middle), *point);
    if (!piece) return;
    const int level = patches_[t][reference].level;
    for (std::size_t i = 0; i < alignments->size(); ++i) {
      const auto& aligned = (*alignments)[i];
      if (!views[i] || !aligned || aligned->correlation < options_.least_correlation) continue;
      // A place told to sigma by pixels up to the radius away tells the affine part by so much.
      const double sigma = std::hypot(0.02, aligned->sigma / (0.5 * options_.radius));
      const double zoom = std::ldexp(1.0, patches_[t][i].level - level);
      piece->AddWarp(*views[i], zoom * aligned->affine.cast<double>(), sigma);
    }
    piece->EstimateSlant();
    for (std::size_t i = 0; i < alignments->size(); ++i) {
      auto& aligned = (*alignments)[i];
      if (!views[i] || !aligned) continue;
      const auto bend = piece->BendInto(*views[i], level, options_.radius);
      if (bend) aligned = fixed.Align(patches_[t][i], aligned->pixel, aligned->affine, *bend);
    }
  }

  std::optional<Eigen::Vector3d> Triangulate(std::size_t t, std::size_t reference,
                                             const std::vector<std::optional<PatchAlignment>>& alignments,
                                             const std::vector<std::optional<PredictedView>>& views) const {
    std::vector<BearingObservation> bearings;
    for (std::size_t i = 0; i < alignments.size(); ++i) {
      if (!views[i]) continue;
      const PredictedView& view = *views[i];
      const Eigen::Vector2f in_patch = i == reference ? patches_[t][i].feature : alignments[i]->pixel;
      BearingObservation bearing;
      if (!Unproject(*view.intrinsics, Pixel(t, i, in_patch), &bearing.direction)) continue;
      bearing.centre = view.T_map_camera.translation;
      bearing.direction = view.T_map_camera.rotation * bearing.direction;
      bearing.sigma = options_.prediction_error;
      bearings.push_back(bearing);
    }
    const auto point = TriangulatePoint(bearings);
    return point ? std::optional<Eigen::Vector3d>(point->position) : std::nullopt;
  }

  bool Accept(std::size_t t, std::size_t reference, std::size_t i, const PatchAlignment& aligned,
              TrackObservation* observation) const {
    const Patch& patch = patches_[t][i];
    const Eigen::Matrix2f warp = Warp(t, reference, i);
    if (aligned.correlation < options_.least_correlation) return false;
    if ((aligned.pixel - patch.feature).norm() > options_.largest_shift) return false;
    const Eigen::Matrix2f deformation = warp.inverse() * aligned.affine - Eigen::Matrix2f::Identity();
    if (deformation.norm() > options_.largest_deformation) return false;
    observation->pixel = FromLevel(aligned.pixel + patch.corner.cast<float>(), patch.level);
    const double fit = options_.sigma_inflation * aligned.sigma * M_SQRT1_2;
    observation->sigma = static_cast<float>(std::hypot(options_.sigma_floor, fit) * (1 << patch.level));
    return true;
  }

  const TrackSet& tracks_;
  const std::vector<FeatureTrack>& feature_tracks_;
  const std::vector<FeatureSet>& features_;
  const ViewOfRow& view_;  // may be empty
  const TrackRefinementOptions& options_;
  std::vector<std::vector<Patch>> patches_;                                    // of each observation
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> of_keyframe_;  // track and observation
};

}  // namespace

TrackSet RefineTracks(const TrackSet& tracks, const std::vector<FeatureTrack>& feature_tracks,
                      const std::vector<FeatureSet>& features, const std::vector<const ImageSource*>& images,
                      const ViewOfRow& view, const TrackRefinementOptions& options,
                      const CancellationToken* cancellation) {
  Check(tracks.tracks.size() == feature_tracks.size(), "RefineTracks: one feature track for each track");
  Refinement refinement(tracks, feature_tracks, features, view, options);
  ParallelFor(tracks.keyframes.size(), [&](std::size_t k) {
    if (!refinement.Uses(k)) return;
    if (cancellation != nullptr) cancellation->ThrowIfCancelled();
    const Keyframe& keyframe = tracks.keyframes[k];
    refinement.CutPatches(k, ToGray(images[keyframe.camera]->Load(keyframe.image)));
  });
  std::vector<Track> refined(tracks.tracks.size());
  ParallelChunks(refined.size(), 256, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) refined[t] = refinement.Refine(t);
  });
  TrackSet result;
  result.keyframes = tracks.keyframes;
  for (Track& track : refined) {
    if (track.observations.size() >= 2) result.tracks.push_back(std::move(track));
  }
  return result;
}

}  // namespace mlic
