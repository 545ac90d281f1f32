#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace mlic::sim {

// Repeatable random functions of the place, for textures.

// Smooth noise of detail down to size (m), summed over `octaves` octaves from size upwards in frequency; 0 to
// 1, mean about one half.
double Fractal(const Eigen::Vector3d& p, double size, int octaves, std::uint32_t seed);

// A constant for each unit square of the plane, uniform in 0 to 1.
double Cell(const Eigen::Vector2d& p, std::uint32_t seed);

}  // namespace mlic::sim
