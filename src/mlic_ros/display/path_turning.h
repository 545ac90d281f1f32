#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// How fast the rig turns along its path: what rotations, lever arms and time offsets are seen by.
struct PathTurning {
  std::vector<double> rates;  // rad/s at each pose, over half a second
  double scale = 0.0;         // deg/s, of the strongest colour: 5, 10, 20, 50 and so on, beyond most of them
};

PathTurning TurningAlong(const std::vector<StampedPose>& trajectory);

std::uint32_t ColourOfRate(double rate, double scale);  // 0xRRGGBB

// The path as lines of these colours, with at most so many points as RViz draws fluently; in frame map. It is
// left out so far around the last pose, m: the rig is drawn there, and a line between it and who looks at it
// would hide it.
visualization_msgs::MarkerArray MakeTurningMarkers(const std::vector<StampedPose>& trajectory,
                                                   const PathTurning& turning, double clearance);

}  // namespace mlic
