#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace mlic {

// The rotation R that maximises trace(R^T * profile) (Wahba's problem, by SVD). With profile = sum of
// a_i b_i^T / sigma_i^2 it is the least-squares R in a_i = R b_i. A guess with a small isotropic sigma about
// it is added to the profile as R_guess / (2 sigma^2). fit (if not null): the value reached, at most the sum
// of the singular values.
Eigen::Quaterniond WahbaRotation(const Eigen::Matrix3d& profile, double* fit = nullptr);

// Both are closed forms, round by round of weights: there is nothing for Ceres to iterate.

// Mean of rotations that keeps to the majority: starts from the one that the others are nearest to in the
// median, and drops what is far from it. sigma: lower bound of the spread, radians. Not empty.
Eigen::Quaterniond RobustMean(const std::vector<Eigen::Quaterniond>& rotations, double sigma);

}  // namespace mlic
