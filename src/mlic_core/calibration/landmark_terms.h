#pragma once

#include "mlic_core/calibration/linear_terms.h"

namespace mlic {

// Adds the reprojection errors of the point landmarks [begin, end) of one drive; ties: one for each point of
// the drive, filled for these.
void AddLandmarks(const LinearizationPoint& at, std::size_t drive, std::size_t begin, std::size_t end,
                  LandmarkTies* ties, Accumulator* sum);

// What AddLandmarks adds to the cost.
double LandmarkCost(const LinearizationPoint& at, std::size_t drive, std::size_t begin, std::size_t end);

// The point moved by a step in its three parameters: two of the bearing from its anchor, and the inverse
// distance.
void MovePoint(const Eigen::Vector3d& step, PointLandmark* point);

}  // namespace mlic
