#include "mlic_core/crossmodal/intensity_map.h"

#include <algorithm>

#include "mlic_core/common/parallel.h"
#include "mlic_core/crossmodal/intensity_compensation.h"
#include "mlic_core/crossmodal/map_surfaces.h"

namespace mlic {
namespace {

std::uint32_t Scramble(std::uint32_t index) {
  std::uint64_t z = (index + 1) * 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  return static_cast<std::uint32_t>(z >> 32);
}

}  // namespace

IntensityMap BuildIntensityMap(const std::vector<MapReturn>& returns, const IntensityMapOptions&) {
  const MapSurfaces surfaces = FindSurfaces(returns);
  const std::vector<float> intensity = CompensateIntensity(returns, surfaces);
  IntensityMap map;
  map.cells = surfaces.cells;
  map.points.resize(returns.size());
  map.origins.resize(returns.size());
  ParallelFor(map.cells.size(), [&](std::size_t c) {
    const MapCell& cell = map.cells[c];
    std::vector<std::uint32_t> order(cell.end - cell.begin);
    for (std::uint32_t k = 0; k < order.size(); ++k) order[k] = cell.begin + k;
    std::sort(order.begin(), order.end(), [](std::uint32_t a, std::uint32_t b) {
      return Scramble(a) != Scramble(b) ? Scramble(a) < Scramble(b) : a < b;
    });
    for (std::uint32_t k = 0; k < order.size(); ++k) {
      const ReturnSurface& surface = surfaces.surfaces[order[k]];
      const MapReturn& r = returns[surfaces.order[order[k]]];
      map.points[cell.begin + k] = {surface.position, intensity[order[k]], surface.normal, surface.spacing};
      map.origins[cell.begin + k] = {r.time, r.lidar};
    }
  });
  return map;
}

IntensityMap BuildIntensityMap(const Drive& drive, const SplitSpline& trajectory,
                               const std::vector<SensorCalibration>& lidars,
                               const IntensityMapOptions& options) {
  return BuildIntensityMap(CollectReturns(drive, trajectory, lidars, options.largest_count), options);
}

}  // namespace mlic
