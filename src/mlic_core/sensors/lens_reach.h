#pragma once

#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

// How far on the way from the middle of the image to a corner the model holds, and a tenth farther out, the
// least of the four: 1 where all of the image sees something, and no pole of its denominator is near.
double ReachOfLens(const CameraIntrinsics& lens);

}  // namespace mlic
