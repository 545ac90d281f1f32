#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/result/result.h"

namespace mlic {

// Moves about a tenth of the matches with the LiDAR map (points with one observation of a LiDAR and one of a
// camera) out of a drive's set, so that no solve uses them, into the set returned. Whole parts of photos
// (160 px wide) go, chosen by camera, image and place: neighbours of a match err as it does, and would tell
// what it told the solve.
LandmarkSet TakeHeldOutMatches(LandmarkSet* matches);

// Reprojection errors of such matches at a state, of each camera: places of the map move along with the LiDAR
// and the trajectory that measured them. held_out: of each drive. Cameras with none have a count of 0.
std::vector<HeldOutMatches> EvaluateHeldOutMatches(const std::vector<LandmarkSet>& held_out,
                                                   const CalibrationState& state);

// What follows a camera's name in the log.
std::string DescribeHeldOut(const HeldOutMatches& matches);

}  // namespace mlic
