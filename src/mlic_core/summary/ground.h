#pragma once

#include <optional>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// How the IMU stands over the ground that the map has below the trajectory, in the mean over places a metre
// apart; none where fewer than three of them have ground. sensors: whose sigmas are part of it.
std::optional<PoseOverGround> FindPoseOverGround(const std::vector<StampedPose>& trajectory,
                                                 const std::vector<MapPoint>& map,
                                                 const std::vector<SensorResult>& sensors);

}  // namespace mlic
