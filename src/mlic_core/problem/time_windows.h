#pragma once

#include <cstddef>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// Seconds over which one plane couples control points. Sigmas grow by 1 to 5 percent (docs/benchmark.md).
constexpr double kLongestCoupling = 20.0;  // from: measured, paper rig, 60 s, seed 1
// The same of points that cameras see: with fewer observations each, they lose more by being cut.
constexpr double kLongestPointCoupling = 30.0;  // from: measured, paper rig, against 20 s and none

// A landmark couples all control points of the times at which it is seen to each other, so that a few walls
// seen again and again over a long drive would make the normal equations dense: cubic in the drive's length.
// Here what is seen of a landmark over more than `longest` seconds becomes several landmarks, one for each
// such stretch from its first observation on; all start where the one was, and come in order of time. What is
// given up is that the trajectory closes its loops over longer times, which adds to a calibration next to
// nothing (docs/benchmark.md); within a stretch all sensors still share their landmarks. Stretches with
// too few observations to fix a landmark are left out. Planes come from the voxel map for such stretches
// already (plane_association.h). origins: for each new point the old one. Points with a LiDAR observation
// stay whole, however far apart camera and LiDAR saw them: the farther, the more control points they tie to
// each other, so pick observations near in time.
LandmarkSet SplitPoints(const LandmarkSet& points, const CalibrationState& state, std::size_t drive,
                        double longest, std::vector<std::size_t>* origins);

// The problem with point landmarks that tie control points over no more than kLongestPointCoupling; planes
// come cut from AssociatePlanes. While the trajectory is held they tie nothing, and stay whole: then origins
// (of each drive, as above) stays empty.
JointProblem WithShortCouplings(const JointProblem& given, const CalibrationState& state,
                                std::vector<std::vector<std::size_t>>* origins);

// The old points, moved to where the split ones with most observations have moved; points of which nothing is
// left stay.
std::vector<PointLandmark> MergePoints(const std::vector<PointLandmark>& old, const LandmarkSet& split,
                                       const std::vector<std::size_t>& origins);

}  // namespace mlic
