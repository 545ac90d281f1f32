#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/camera/tracks/tracks.h"

namespace mlic {

// What one camera sees of the same points in two of its keyframes.
struct PixelMatches {
  std::size_t drive = 0;
  double time_a = 0.0, time_b = 0.0;  // s, camera clock
  std::vector<Eigen::Vector2d> pixels_a, pixels_b;
};

// Of consecutive keyframes of one camera (at most 3 s apart), from the tracks that both see. tracks: of each
// drive.
std::vector<PixelMatches> MatchesOfKeyframes(const std::vector<TrackSet>& tracks, int camera);

// At most so many of the pairs and so many matches of each, evenly chosen.
std::vector<PixelMatches> Thinned(const std::vector<PixelMatches>& pairs, std::size_t most_pairs,
                                  std::size_t most_matches);

}  // namespace mlic
