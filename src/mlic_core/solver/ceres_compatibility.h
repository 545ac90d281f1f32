#pragma once

#include <ceres/problem.h>
#include <ceres/version.h>

#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
#define MLIC_CERES_HAS_MANIFOLDS 1
#include <ceres/manifold.h>
#else
#define MLIC_CERES_HAS_MANIFOLDS 0
#include <ceres/local_parameterization.h>
#endif

namespace mlic {

// What differs between Ceres 1.14, 2.1 and 2.2 stands here and nowhere else.

#if MLIC_CERES_HAS_MANIFOLDS
using CeresManifold = ceres::Manifold;
using CeresSubsetManifold = ceres::SubsetManifold;
using CeresQuaternionManifold = ceres::EigenQuaternionManifold;
#else
using CeresManifold = ceres::LocalParameterization;
using CeresSubsetManifold = ceres::SubsetParameterization;
using CeresQuaternionManifold = ceres::EigenQuaternionParameterization;
#endif

// Whose the manifold is then, the problem's options say (theirs by default).
inline void SetManifold(ceres::Problem* problem, double* block, CeresManifold* manifold) {
#if MLIC_CERES_HAS_MANIFOLDS
  problem->SetManifold(block, manifold);
#else
  problem->SetParameterization(block, manifold);
#endif
}

// Manifolds stay the caller's.
inline void KeepManifolds(ceres::Problem::Options* options) {
#if MLIC_CERES_HAS_MANIFOLDS
  options->manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
#else
  options->local_parameterization_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
#endif
}

// The block holds a unit quaternion in Eigen's order x y z w. Its tangent is half of a left perturbation:
// Plus(q, d) = Exp(2 d) * q.
inline void SetQuaternionManifold(ceres::Problem* problem, double* block) {
  SetManifold(problem, block, new CeresQuaternionManifold);
}

}  // namespace mlic
