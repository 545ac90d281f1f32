#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "mlic_core/camera/features/features.h"
#include "mlic_core/camera/tracks/image_pairs.h"
#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/sensors/images.h"

namespace mlic {

// Features of one point are found in each image for themselves, a few tenths of a pixel off. Here the patch
// about the feature in one image of the track, the reference, is found again in all others (Lucas and Kanade,
// IJCAI 1981; inverse compositional: Baker and Matthews, IJCV 2004) under an affine warp, an offset, and a
// gain that changes linearly across the patch (lenses shade their corners). The reference's own error is no
// error of the track: it only says which point of the surface is meant.
struct TrackRefinementOptions {
  // from: measured, paper rig, seeds 1 and 3: best of 5 to 13 px.
  int radius = 9;  // px of the patch, in the pyramid's level that fits the feature's scale
  // from: guard, features are some tenths of a pixel off.
  double largest_shift = 3.0;       // px of that level, from the feature
  double least_correlation = 0.85;  // from: measured, paper rig, seeds 1 and 3
  double largest_deformation =
      0.5;  // of the affine part, from the one that the features' scales and angles give
  // sigma^2 = floor^2 + (inflation * sigma of the fit)^2, px of the level; half of the variance of the
  // difference of two images goes to each.
  double sigma_floor = 0.04;       // from: measured, paper rig, seeds 1 and 3
  double sigma_inflation = 2.0;    // from: measured, paper rig, seeds 1 and 3
  double prediction_error = 3e-3;  // rad, of bearings by predicted views
};

// Predicted, while a row of a keyframe is exposed; nothing where not known.
using ViewOfRow = std::function<std::optional<PredictedView>(const Keyframe& keyframe, double row)>;

// images: of each camera. feature_tracks[i] are the features of tracks.tracks[i]'s observations. Images are
// read one at a time for each thread; of each only the patches are kept. Observations that do not fit are
// dropped, and then tracks with fewer than two left. view: may be empty; else patches are bent as perspective
// and lenses bend them.
TrackSet RefineTracks(const TrackSet& tracks, const std::vector<FeatureTrack>& feature_tracks,
                      const std::vector<FeatureSet>& features, const std::vector<const ImageSource*>& images,
                      const ViewOfRow& view, const TrackRefinementOptions& options,
                      const CancellationToken* cancellation = nullptr);

}  // namespace mlic
