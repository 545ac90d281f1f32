#pragma once

#include <ceres/problem.h>
#include <ceres/version.h>

#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
#include <ceres/manifold.h>
#else
#include <ceres/local_parameterization.h>
#endif

namespace mlic {

// What differs between Ceres 1.14, 2.1 and 2.2 stands here and nowhere else.

// The block holds a unit quaternion in Eigen's order x y z w. Its tangent is half of a left perturbation:
// Plus(q, d) = Exp(2 d) * q.
inline void SetQuaternionManifold(ceres::Problem* problem, double* block) {
#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
  problem->SetManifold(block, new ceres::EigenQuaternionManifold);
#else
  problem->SetParameterization(block, new ceres::EigenQuaternionParameterization);
#endif
}

}  // namespace mlic
