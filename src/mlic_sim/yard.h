#pragma once

#include "mlic_sim/mesh.h"

namespace mlic::sim {

// A yard of about 80 x 60 m: buildings, parked cars, poles, trees, kerbs, markings. The ground is slightly
// uneven (UnevenGroundHeight) or perfectly flat.
Mesh YardMesh(bool flat_ground);

}  // namespace mlic::sim
