#pragma once

#include <cstdint>
#include <vector>

#include "mlic_core/crossmodal/intensity_map.h"

namespace mlic {

// What the neighbourhood of a return says about the surface that sent it.
struct ReturnSurface {
  Eigen::Vector3f position;                          // with less range noise
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, towards the sensor; zero: no plane
  float spacing = 0.0f;                              // m
  float weight = 1.0f;                               // as of SurfacePoint
  bool stray = false;  // lies alone beside dense surfaces: the mean of two that its beam hit, or noise
};

// Returns sorted into an octree (root 4 m, leaves 0.125 m) and what it says of each.
struct MapSurfaces {
  std::vector<std::uint32_t> order;     // of the returns, cell after cell
  std::vector<MapCell> cells;           // over `order`
  std::vector<std::uint32_t> patches;   // over `order`: [patches[k], patches[k+1]) are of one small patch
  std::vector<ReturnSurface> surfaces;  // in order of `order`
  double range_noise = 0.0;             // m, as measured
};

// The octree is split where there are points enough to tell more, until they fit a plane within their noise.
// A range is corrected towards the patch's plane along its beam, by the share that the noises of both
// suggest.
MapSurfaces FindSurfaces(const std::vector<MapReturn>& returns);

}  // namespace mlic
