#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/camera/features/features.h"

namespace mlic {

// One image that features are taken from. time: stamp on the camera's own clock, s since the drive's epoch.
struct Keyframe {
  int camera = 0;         // of Drive::cameras
  std::size_t image = 0;  // of the camera's ImageSource
  double time = 0.0;
};

// Where one keyframe sees the point of a track. sigma: px, of each coordinate of the pixel.
struct TrackObservation {
  std::int32_t keyframe = 0;
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  float sigma = 0.5f;
};

// One fixed point of the world as several keyframes see it, each at most once. Ordered by keyframe.
struct Track {
  std::vector<TrackObservation> observations;
};

// Keyframes ordered by camera, then time.
struct TrackSet {
  std::vector<Keyframe> keyframes;
  std::vector<Track> tracks;
};

// Matches of two keyframes (keyframe_a < keyframe_b) that passed the geometric check: indices into their
// feature sets.
struct PairMatches {
  std::int32_t keyframe_a = 0;
  std::int32_t keyframe_b = 0;
  std::vector<FeatureMatch> matches;
};

// A feature of a keyframe, and the features that are one point, ordered by keyframe.
struct FeatureReference {
  std::int32_t keyframe = 0;
  std::int32_t feature = 0;
};
using FeatureTrack = std::vector<FeatureReference>;

// Joins matches to tracks, the best matches first. A match that would give a track two features of one
// keyframe is left out; a track with more than largest_conflict_share of such matches is dropped whole, as it
// is probably two points. feature_counts: of each keyframe. Tracks of fewer than least_length are dropped.
std::vector<FeatureTrack> JoinMatches(const std::vector<std::size_t>& feature_counts,
                                      const std::vector<PairMatches>& pairs, int least_length = 2,
                                      double largest_conflict_share = 0.25);

// Tracks with the pixels of their features; sigma: sigma_at_unit_scale px times the scale of the feature, at
// least least_sigma.
TrackSet TracksOfFeatures(const std::vector<Keyframe>& keyframes, const std::vector<FeatureSet>& features,
                          const std::vector<FeatureTrack>& feature_tracks, double sigma_at_unit_scale = 0.25,
                          double least_sigma = 0.4);

struct TrackSelectionOptions {
  int most_in_keyframe = 300;  // from: guard, time
  int grid = 10;  // cells along the longer side of an image; from: structural, parts of the image
};

// The most useful tracks: long ones first, as long as at least two of their keyframes (and a third of them)
// still have room in the cell of the grid where they see the point. image_sizes: of each keyframe, width and
// height. Returns indices into tracks.tracks, in their order.
std::vector<std::size_t> SelectTracks(const TrackSet& tracks,
                                      const std::vector<std::pair<int, int>>& image_sizes,
                                      const TrackSelectionOptions& options);

}  // namespace mlic
