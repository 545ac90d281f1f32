#pragma once

#include <vector>

#include "mlic_core/crossmodal/map_surfaces.h"

namespace mlic {

// Brightness of each return, in order of surfaces.order: 0 to 1, what the surface itself is, whoever saw it
// from wherever.
std::vector<float> CompensateIntensity(const std::vector<MapReturn>& returns, const MapSurfaces& surfaces);

}  // namespace mlic
