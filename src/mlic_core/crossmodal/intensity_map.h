#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mlic_core/crossmodal/map_returns.h"
#include "mlic_core/crossmodal/map_surfaces.h"

namespace mlic {

// A point of a surface as it is drawn.
struct SurfacePoint {
  Eigen::Vector3f position;  // m, map frame; range noise is reduced where the surface is a plane
  float intensity = 0.0f;    // 0 to 1, range, incidence and sensor compensated
  Eigen::Vector3f normal;    // unit, on the side it was seen from; zero where there is no plane
  float spacing = 0.0f;      // m, to the neighbours on the surface
  float weight = 1.0f;       // of its intensity among its neighbours': sharp, well-lit looks count more
};

// Which beam a point comes from.
struct PointOrigin {
  double time = 0.0;  // LiDAR clock, s since the drive's epoch
  std::int32_t lidar = 0;
};

// The joint map of all LiDARs of one drive, made to be looked at by cameras. Points and origins go together.
struct IntensityMap {
  std::vector<SurfacePoint> points;
  std::vector<PointOrigin> origins;
  std::vector<MapCell> cells;
};

struct IntensityMapOptions {
  bool remove_moving = true;  // what other beams saw through at other times is left out
};

// The map of any returns (a drive's, or one scan's). Intensities of all LiDARs are brought to one scale from
// what they saw in common. The result does not depend on the number of threads.
IntensityMap BuildIntensityMap(const std::vector<MapReturn>& returns,
                               const IntensityMapOptions& options = {});

}  // namespace mlic
