#pragma once

#include <cstddef>

#include "mlic_core/sensors/measurements.h"

namespace mlic {

// Takes out what a LiDAR sees of its own vehicle (roof rack, mirrors, the carrier's head): what stays at the
// same place in the sensor's frame, within 4 m, in most scans while the rest of the scene moves. What reaches
// on beyond those 4 m is scene (flat ground, a corridor's walls) and stays, and from a rig that stands still
// nothing is taken. Returns how many points were taken out.
std::size_t RemoveOwnBody(LidarRecording* recording);

}  // namespace mlic
