#pragma once

#include "mlic_core/geometry/rigid_transform.h"

namespace mlic {

// A pose and when it held: seconds since the drive's epoch on the clock of the sensor whose pose it is.
struct TimedPose {
  double time = 0.0;
  RigidTransform pose;
};

}  // namespace mlic
