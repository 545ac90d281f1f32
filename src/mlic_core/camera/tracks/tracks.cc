#include "mlic_core/camera/tracks/tracks.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

// Disjoint sets of features, none with two features of one keyframe.
class FeatureSets {
 public:
  explicit FeatureSets(const std::vector<std::size_t>& feature_counts) {
    first_.push_back(0);
    for (const std::size_t count : feature_counts) first_.push_back(first_.back() + count);
    parent_.resize(first_.back());
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    members_.resize(first_.back());
    conflicts_.assign(first_.back(), 0);
    edges_.assign(first_.back(), 0);
    for (std::size_t k = 0; k < feature_counts.size(); ++k) {
      for (std::size_t f = 0; f < feature_counts[k]; ++f) {
        members_[first_[k] + f] = {{static_cast<std::int32_t>(k), static_cast<std::int32_t>(f)}};
      }
    }
  }

  void Join(const FeatureReference& a, const FeatureReference& b) {
    std::size_t p = Root(first_[a.keyframe] + a.feature), q = Root(first_[b.keyframe] + b.feature);
    if (p == q) {
      ++edges_[p];
      return;
    }
    if (members_[p].size() < members_[q].size()) std::swap(p, q);
    const auto by_keyframe = [](const FeatureReference& x, const FeatureReference& y) {
      return x.keyframe < y.keyframe;
    };
    for (const FeatureReference& member : members_[q]) {
      if (std::binary_search(members_[p].begin(), members_[p].end(), member, by_keyframe)) {
        ++conflicts_[p];
        ++conflicts_[q];
        return;
      }
    }
    FeatureTrack merged(members_[p].size() + members_[q].size());
    std::merge(members_[p].begin(), members_[p].end(), members_[q].begin(), members_[q].end(), merged.begin(),
               by_keyframe);
    members_[p] = std::move(merged);
    members_[q] = FeatureTrack();
    parent_[q] = p;
    conflicts_[p] += conflicts_[q];
    edges_[p] += edges_[q] + 1;
  }

  std::vector<FeatureTrack> Tracks(std::size_t least_length, double largest_conflict_share) {
    std::vector<FeatureTrack> tracks;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      if (members_[i].size() < least_length) continue;
      if (conflicts_[i] > largest_conflict_share * (edges_[i] + conflicts_[i])) continue;
      tracks.push_back(members_[i]);
    }
    return tracks;
  }

 private:
  std::size_t Root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  std::vector<std::size_t> first_, parent_;
  std::vector<FeatureTrack> members_;  // of the roots, ordered by keyframe
  std::vector<int> conflicts_, edges_;
};

}  // namespace

std::vector<FeatureTrack> JoinMatches(const std::vector<std::size_t>& feature_counts,
                                      const std::vector<PairMatches>& pairs, int least_length,
                                      double largest_conflict_share) {
  std::vector<std::tuple<float, std::size_t, std::size_t>> order;  // minus the score, pair, match
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    for (std::size_t m = 0; m < pairs[p].matches.size(); ++m) {
      order.emplace_back(-pairs[p].matches[m].score, p, m);
    }
  }
  std::sort(order.begin(), order.end());
  FeatureSets sets(feature_counts);
  for (const auto& [score, p, m] : order) {
    const FeatureMatch& match = pairs[p].matches[m];
    sets.Join({pairs[p].keyframe_a, match.a}, {pairs[p].keyframe_b, match.b});
  }
  return sets.Tracks(std::max(1, least_length), largest_conflict_share);
}

TrackSet TracksOfFeatures(const std::vector<Keyframe>& keyframes, const std::vector<FeatureSet>& features,
                          const std::vector<FeatureTrack>& feature_tracks, double sigma_at_unit_scale,
                          double least_sigma) {
  Check(keyframes.size() == features.size(), "TracksOfFeatures: one feature set for each keyframe");
  TrackSet set;
  set.keyframes = keyframes;
  set.tracks.reserve(feature_tracks.size());
  for (const FeatureTrack& feature_track : feature_tracks) {
    Track track;
    for (const FeatureReference& reference : feature_track) {
      const FeatureSet& of_keyframe = features[reference.keyframe];
      TrackObservation observation;
      observation.keyframe = reference.keyframe;
      observation.pixel = of_keyframe.pixels[reference.feature];
      observation.sigma = static_cast<float>(
          std::max(least_sigma, sigma_at_unit_scale * of_keyframe.scales[reference.feature]));
      track.observations.push_back(observation);
    }
    set.tracks.push_back(std::move(track));
  }
  return set;
}

std::vector<std::size_t> SelectTracks(const TrackSet& tracks,
                                      const std::vector<std::pair<int, int>>& image_sizes,
                                      const TrackSelectionOptions& options) {
  Check(image_sizes.size() == tracks.keyframes.size(), "SelectTracks: one image size for each keyframe");
  const int grid = std::max(1, options.grid);
  // As many in a cell that a full grid has most_in_keyframe; images are wider than high, so a grid has fewer
  // than grid^2 cells.
  std::vector<std::vector<int>> taken(image_sizes.size(), std::vector<int>(grid * grid, 0));
  const auto cell = [&](const TrackObservation& observation) {
    const auto& size = image_sizes[observation.keyframe];
    const double width = std::max(size.first, size.second) / static_cast<double>(grid);
    const int column = std::clamp(static_cast<int>(observation.pixel.x() / width), 0, grid - 1);
    const int row = std::clamp(static_cast<int>(observation.pixel.y() / width), 0, grid - 1);
    return row * grid + column;
  };
  std::vector<int> room(image_sizes.size());
  for (std::size_t k = 0; k < image_sizes.size(); ++k) {
    const double longer = std::max(image_sizes[k].first, image_sizes[k].second);
    const double shorter = std::min(image_sizes[k].first, image_sizes[k].second);
    room[k] = static_cast<int>(std::ceil(options.most_in_keyframe * longer / (shorter * grid * grid)));
  }
  std::vector<std::size_t> order(tracks.tracks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return tracks.tracks[a].observations.size() > tracks.tracks[b].observations.size();
  });
  std::vector<std::size_t> chosen;
  for (const std::size_t i : order) {
    const auto& observations = tracks.tracks[i].observations;
    std::size_t with_room = 0;
    for (const TrackObservation& observation : observations) {
      with_room += taken[observation.keyframe][cell(observation)] < room[observation.keyframe];
    }
    if (with_room < 2 || 3 * with_room < observations.size()) continue;
    for (const TrackObservation& observation : observations) ++taken[observation.keyframe][cell(observation)];
    chosen.push_back(i);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace mlic
