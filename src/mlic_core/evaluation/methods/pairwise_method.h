#pragma once

#include <functional>
#include <string>

#include "mlic_core/common/progress.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// A rival to compare with: two sensors at a time. The rig's first LiDAR (without one its first camera), the
// reference, is calibrated to the IMU alone, and each other sensor together with the reference alone, by the
// whole calibration with all that it does for a rig of two; so each camera has a lens of its own pair. The
// rest is chained: T_imu_b = T_imu_reference T_reference_b, and time offsets likewise. What is left out is
// the map, the tracks and the trajectory that all sensors share. docs/method.md, section 13. Poses, time
// offsets and intrinsics only, no sigmas; sensors whose pair gives no pose are among the rejected. on_pair:
// told before each calibration what it is of.
CalibrationResult CalibratePairwise(const Rig& rig, const Dataset& dataset,
                                    const CancellationToken& cancellation,
                                    const std::function<void(const std::string&)>& on_pair);

}  // namespace mlic
