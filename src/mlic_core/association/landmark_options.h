#pragma once

#include <cstddef>
#include <vector>

#include "mlic_core/camera/two_view/triangulation.h"

namespace mlic {

// The noise of one camera's observations, of what the tracks claim (the calibration's own errors come on top
// while it is far from right).
struct LandmarkNoise {
  double spread = 1.0;  // of single observations, outliers aside: what an observation is judged by
  double dependence =
      1.0;  // observations that share errors count for less: their sigmas are that much larger
};

struct LandmarkOptions {
  std::vector<LandmarkNoise> noise;  // of each camera; empty: as the tracks claim
  double least_sigma = 0.0;          // px; no observation counts for better; from: structural
  double largest_error = 4.0;        // sigmas; from: derivation, 1 of 3000 observations lies beyond
  double least_parallax_deg = TriangulationOptions().least_parallax_deg;
  // Each landmark's noise is its own: corners at steps of depth, reflections and moving shadows look unlike
  // themselves from elsewhere, and their observations agree less than those of a mark on a road. Only once
  // the calibration is nearly right: before, landmarks that say much about it disagree the most.
  bool noise_of_each = false;
  std::size_t most_points = 30000;  // in one drive; the longest tracks are kept; from: guard, memory
};

}  // namespace mlic
