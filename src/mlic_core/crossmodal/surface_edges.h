#pragma once

#include <vector>

#include "mlic_core/crossmodal/map_surfaces.h"

namespace mlic {

// Gives returns whose own neighbourhood is no plane, as it holds an edge or a recess, to the plane beside
// them that they lie on within their noise. Their incidence is known by that, and with it how bright the
// surface is: else every window and pilaster gets a frame that no photo shows. What lies on no plane stays as
// it is: twigs, and beams that met two surfaces.
void ExtendPlanesToEdges(const std::vector<MapReturn>& returns, MapSurfaces* surfaces);

}  // namespace mlic
