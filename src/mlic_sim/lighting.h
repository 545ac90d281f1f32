#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_sim/world.h"

namespace mlic::sim {

// Light of a world. Linear red, green, blue; 1 is what a white surface sends back when the sun (or the lamps)
// light it squarely.
struct Lighting {
  bool outdoors = true;
  Eigen::Vector3f to_sun = Eigen::Vector3f(0.48f, -0.52f, 0.71f);  // unit after construction
  Eigen::Vector3f sun = Eigen::Vector3f(0.78f, 0.74f, 0.66f);
  Eigen::Vector3f bounce = Eigen::Vector3f(0.10f, 0.095f, 0.085f);  // from directions where something stands
  std::vector<Eigen::Vector3f> lamps;                               // places, m; indoors
  Eigen::Vector3f lamp = Eigen::Vector3f(2.6f, 2.5f, 2.25f);        // at 1 m
};

Lighting YardLighting();
Lighting HallLighting();

// What is seen where no surface is. direction: unit, map frame.
Eigen::Vector3f SkyRadiance(const Lighting& lighting, const Eigen::Vector3f& direction);

// Light from all around (sky, surroundings) that falls on a surface at p with a unit normal, as a share of
// white.
Eigen::Vector3f AmbientLight(const World& world, const Lighting& lighting, const Eigen::Vector3f& p,
                             const Eigen::Vector3f& normal);

// The same of the sun or the lamps, with shadows.
Eigen::Vector3f DirectLight(const World& world, const Lighting& lighting, const Eigen::Vector3f& p,
                            const Eigen::Vector3f& normal);

}  // namespace mlic::sim
