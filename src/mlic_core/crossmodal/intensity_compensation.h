#pragma once

#include <vector>

#include "mlic_core/crossmodal/map_surfaces.h"

namespace mlic {

// Brightness of each return, in order of surfaces.order: 0 to 1, what the surface itself is, whoever saw it
// from wherever. The model is
//   log(intensity) = log(brightness of the patch) + range_l(log range) + incidence_l(cosine) + ring_l(ring)
// with piecewise linear functions for each LiDAR l, found by robust least squares from patches that were seen
// several times, by several LiDARs where there are. Brightness is the square root of what the model leaves
// (about a photo's gamma), scaled so that nearly all lie between 0 and 1.
//
// Intensities without any scale (all alike, all zero) give 0.5.
std::vector<float> CompensateIntensity(const std::vector<MapReturn>& returns, const MapSurfaces& surfaces);

}  // namespace mlic
