#pragma once

#include <cstdint>
#include <vector>

#include "mlic_core/crossmodal/map_surfaces.h"

namespace mlic {

// Which points (in order of surfaces.order) do not stand still: 1 where beams before or after the time that a
// small patch was hit went right through it, and hardly any hit it then. A parked car that leaves is found as
// well as one that passes; so are points that never were on a surface (a beam's mean of two). What only one
// moment saw stays. returns must be in order of LiDAR and time.
std::vector<std::uint8_t> FindMovingPoints(const std::vector<MapReturn>& returns,
                                           const MapSurfaces& surfaces);

}  // namespace mlic
