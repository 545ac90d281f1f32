#pragma once

#include <memory>

#include "mlic_sim/world.h"

namespace mlic::sim {

// A hall of 24 x 16 x 6 m with pillars, shelves, tables, boxes and tilted boards; the middle (|x| < 7.5 m,
// |y| < 4 m) holds nothing higher than 0.8 m.
Mesh HallMesh();
std::unique_ptr<World> MakeHall(InfraredLook infrared = InfraredLook::kRelated);

}  // namespace mlic::sim
