#pragma once

#include <memory>

#include "mlic_sim/world.h"

namespace mlic::sim {

// A yard of about 80 x 60 m: buildings, parked cars, poles, trees, kerbs, markings. The ground is slightly
// uneven (UnevenGroundHeight) or perfectly flat.
std::unique_ptr<World> MakeYard(bool flat_ground, InfraredLook infrared = InfraredLook::kRelated);

}  // namespace mlic::sim
