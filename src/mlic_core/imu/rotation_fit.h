#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace mlic {

// Both are closed forms, round by round of weights: there is nothing for Ceres to iterate.

// Mean of rotations that keeps to the majority: starts from the one that the others are nearest to in the
// median, and drops what is far from it. sigma: lower bound of the spread, radians. Not empty.
Eigen::Quaterniond RobustMean(const std::vector<Eigen::Quaterniond>& rotations, double sigma);

}  // namespace mlic
