#pragma once

#include <Eigen/Core>

namespace mlic {

// The rotation R that maximises trace(R^T * profile) (Wahba's problem, by SVD). With profile = sum of
// a_i b_i^T / sigma_i^2 it is the least-squares R in a_i = R b_i. A guess with a small isotropic sigma about
// it is added to the profile as R_guess / (2 sigma^2). fit (if not null): the value reached, at most the sum
// of the singular values.
Eigen::Matrix3d WahbaRotation(const Eigen::Matrix3d& profile, double* fit = nullptr);

}  // namespace mlic
