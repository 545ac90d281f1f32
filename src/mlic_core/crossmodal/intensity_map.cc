#include "mlic_core/crossmodal/intensity_map.h"

#include <algorithm>

#include "mlic_core/common/parallel.h"
#include "mlic_core/crossmodal/intensity_compensation.h"
#include "mlic_core/crossmodal/map_surfaces.h"
#include "mlic_core/crossmodal/moving_points.h"
#include "mlic_core/crossmodal/surface_edges.h"

namespace mlic {
namespace {

std::uint32_t Scramble(std::uint32_t index) {
  std::uint64_t z = (index + 1) * 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  return static_cast<std::uint32_t>(z >> 32);
}

// The points of each cell that stay, in random order.
std::vector<std::vector<std::uint32_t>> ChoosePoints(const MapSurfaces& surfaces,
                                                     const std::vector<std::uint8_t>& moving) {
  std::vector<std::vector<std::uint32_t>> chosen(surfaces.cells.size());
  ParallelFor(chosen.size(), [&](std::size_t c) {
    for (std::uint32_t k = surfaces.cells[c].begin; k < surfaces.cells[c].end; ++k) {
      if (!surfaces.surfaces[k].stray && (moving.empty() || !moving[k])) chosen[c].push_back(k);
    }
    std::sort(chosen[c].begin(), chosen[c].end(), [](std::uint32_t a, std::uint32_t b) {
      return Scramble(a) != Scramble(b) ? Scramble(a) < Scramble(b) : a < b;
    });
  });
  return chosen;
}

}  // namespace

IntensityMap BuildIntensityMap(const std::vector<MapReturn>& returns, const IntensityMapOptions& options) {
  if (returns.empty()) return {};
  MapSurfaces surfaces = FindSurfaces(returns);
  std::vector<std::uint8_t> moving;
  if (options.remove_moving) moving = FindMovingPoints(returns, surfaces);
  ExtendPlanesToEdges(returns, &surfaces);
  const std::vector<float> intensity = CompensateIntensity(returns, surfaces);
  const std::vector<std::vector<std::uint32_t>> chosen = ChoosePoints(surfaces, moving);
  IntensityMap map;
  std::uint32_t count = 0;
  std::vector<std::size_t> cell_of;
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    if (chosen[c].empty()) continue;
    map.cells.push_back(surfaces.cells[c]);
    map.cells.back().begin = count;
    map.cells.back().end = count += static_cast<std::uint32_t>(chosen[c].size());
    cell_of.push_back(c);
  }
  map.points.resize(count);
  map.origins.resize(count);
  ParallelFor(map.cells.size(), [&](std::size_t c) {
    std::size_t k = map.cells[c].begin;
    for (const std::uint32_t from : chosen[cell_of[c]]) {
      const ReturnSurface& surface = surfaces.surfaces[from];
      const MapReturn& r = returns[surfaces.order[from]];
      map.points[k] = {surface.position, intensity[from], surface.normal, surface.spacing, surface.weight};
      map.origins[k] = {r.time, r.lidar};
      ++k;
    }
  });
  return map;
}

}  // namespace mlic
