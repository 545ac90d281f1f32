#pragma once

#include <Eigen/Core>

#include "mlic_core/common/random.h"

namespace mlic::sim {

// A unit vector, evenly over the sphere.
inline Eigen::Vector3d RandomDirection(Random* random) {
  const double x = random->Normal(), y = random->Normal(), z = random->Normal();
  return Eigen::Vector3d(x, y, z).normalized();
}

}  // namespace mlic::sim
