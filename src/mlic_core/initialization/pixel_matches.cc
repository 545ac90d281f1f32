#include "mlic_core/initialization/pixel_matches.h"

#include <algorithm>

#include "mlic_core/camera/tracks/feature_tracking.h"

namespace mlic {
namespace {

void Collect(const TrackSet& tracks, std::size_t drive, int camera, std::vector<PixelMatches>* pairs) {
  const double longest = FollowOptions().largest_interval;  // beyond it features are not followed
  std::vector<int> pair_of(tracks.keyframes.size(), -1);    // of each keyframe with the next one
  for (std::size_t k = 0; k + 1 < tracks.keyframes.size(); ++k) {
    const Keyframe &a = tracks.keyframes[k], &b = tracks.keyframes[k + 1];
    if (a.camera != camera || b.camera != camera || b.time - a.time > longest) continue;
    pair_of[k] = static_cast<int>(pairs->size());
    pairs->push_back({drive, a.time, b.time, {}, {}});
  }
  for (const Track& track : tracks.tracks) {
    for (std::size_t i = 0; i + 1 < track.observations.size(); ++i) {
      const TrackObservation &a = track.observations[i], &b = track.observations[i + 1];
      if (b.keyframe != a.keyframe + 1 || pair_of[a.keyframe] < 0) continue;
      PixelMatches& pair = (*pairs)[pair_of[a.keyframe]];
      pair.pixels_a.push_back(a.pixel.cast<double>());
      pair.pixels_b.push_back(b.pixel.cast<double>());
    }
  }
}

}  // namespace

std::vector<PixelMatches> MatchesOfKeyframes(const std::vector<TrackSet>& tracks, int camera) {
  std::vector<PixelMatches> pairs;
  for (std::size_t d = 0; d < tracks.size(); ++d) Collect(tracks[d], d, camera, &pairs);
  return pairs;
}

std::vector<PixelMatches> Thinned(const std::vector<PixelMatches>& pairs, std::size_t most_pairs,
                                  std::size_t most_matches) {
  const std::size_t step = (pairs.size() + most_pairs - 1) / std::max<std::size_t>(1, most_pairs);
  std::vector<PixelMatches> thinned;
  for (std::size_t k = 0; k < pairs.size(); k += std::max<std::size_t>(1, step)) {
    const PixelMatches& all = pairs[k];
    PixelMatches kept{all.drive, all.time_a, all.time_b, {}, {}};
    const std::size_t count = std::min(most_matches, all.pixels_a.size());
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t of = i * all.pixels_a.size() / count;
      kept.pixels_a.push_back(all.pixels_a[of]);
      kept.pixels_b.push_back(all.pixels_b[of]);
    }
    thinned.push_back(std::move(kept));
  }
  return thinned;
}

}  // namespace mlic
