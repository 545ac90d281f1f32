#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "mlic_sim/material.h"

namespace mlic::sim {

// Where a ray ends.
struct RayHit {
  double range;              // along the ray, m
  Eigen::Vector3d position;  // map frame; of what moves: in its own frame, so that its look moves along
  Eigen::Vector3d normal;    // unit, map frame, towards the ray's origin
  Material material;
  std::uint32_t object;
};

}  // namespace mlic::sim
