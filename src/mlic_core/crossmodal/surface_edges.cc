#include "mlic_core/crossmodal/surface_edges.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

// from: guard, returns within 0.12 m of an edge have no plane of their own.
constexpr double kCell = 0.25;   // m: planes of neighbouring cells are tried
constexpr double kSigmas = 2.0;  // off a plane; others are more likely of an edge's mixed beams
constexpr int kCellBits = 21;    // of each axis in a key; from: structural

std::int64_t CellOf(float x) { return static_cast<std::int64_t>(std::floor(x / kCell)); }

std::uint64_t KeyOf(std::int64_t x, std::int64_t y, std::int64_t z) {
  // from: structural.
  constexpr std::int64_t kHalf = std::int64_t{1} << (kCellBits - 1), kMask = 2 * kHalf - 1;
  const auto bits = [&](std::int64_t cell) { return static_cast<std::uint64_t>((cell + kHalf) & kMask); };
  return (bits(x) << (2 * kCellBits)) | (bits(y) << kCellBits) | bits(z);
}

// A plane that has points in a cell.
struct PlaneInCell {
  std::uint64_t cell;
  std::uint32_t plane;

  bool operator<(const PlaneInCell& other) const {
    return cell != other.cell ? cell < other.cell : plane < other.plane;
  }
  bool operator==(const PlaneInCell& other) const { return cell == other.cell && plane == other.plane; }
};

std::vector<PlaneInCell> IndexPlanes(const MapSurfaces& surfaces) {
  constexpr std::size_t kChunks = 64;  // from: structural, parts of the work
  std::vector<std::vector<PlaneInCell>> parts(kChunks);
  ParallelChunks(surfaces.planes.size(), kChunks, [&](std::size_t c, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const std::size_t begin = parts[c].size();
      for (std::uint32_t k = surfaces.planes[i].begin; k < surfaces.planes[i].end; ++k) {
        if (surfaces.surfaces[k].normal.isZero()) continue;
        const Eigen::Vector3f& p = surfaces.surfaces[k].position;
        const std::uint64_t cell = KeyOf(CellOf(p.x()), CellOf(p.y()), CellOf(p.z()));
        const bool same = parts[c].size() > begin && parts[c].back().cell == cell;
        if (!same) parts[c].push_back({cell, static_cast<std::uint32_t>(i)});
      }
      std::sort(parts[c].begin() + static_cast<std::ptrdiff_t>(begin), parts[c].end());
      parts[c].erase(std::unique(parts[c].begin() + static_cast<std::ptrdiff_t>(begin), parts[c].end()),
                     parts[c].end());
    }
  });
  std::vector<PlaneInCell> index;
  for (const auto& part : parts) index.insert(index.end(), part.begin(), part.end());
  std::sort(index.begin(), index.end());
  return index;
}

// The plane nearest to the return in units of its noise, among those of the cells around; null for none.
const SurfacePlane* PlaneBeside(const MapReturn& r, const MapSurfaces& surfaces,
                                const std::vector<PlaneInCell>& index) {
  const SurfacePlane* best = nullptr;
  double least = kSigmas;
  const Eigen::Vector3d p = r.position.cast<double>(), direction = r.beam.cast<double>().normalized();
  const std::int64_t x = CellOf(r.position.x()), y = CellOf(r.position.y()), z = CellOf(r.position.z());
  for (std::int64_t dx = -1; dx <= 1; ++dx) {
    for (std::int64_t dy = -1; dy <= 1; ++dy) {
      // Cells that follow each other in z have keys that do.
      const std::uint64_t first = KeyOf(x + dx, y + dy, z - 1), last = KeyOf(x + dx, y + dy, z + 1);
      for (auto it = std::lower_bound(index.begin(), index.end(), PlaneInCell{first, 0});
           it != index.end() && it->cell <= last; ++it) {
        const SurfacePlane& plane = surfaces.planes[it->plane];
        const double noise = NoiseOffPlane(plane.normal.dot(direction), surfaces.range_noise);
        const double sigmas = std::abs(plane.normal.dot(p - plane.center)) / noise;
        if (sigmas < least) least = sigmas, best = &plane;
      }
    }
  }
  return best;
}

}  // namespace

void ExtendPlanesToEdges(const std::vector<MapReturn>& returns, MapSurfaces* surfaces) {
  const std::vector<PlaneInCell> index = IndexPlanes(*surfaces);
  const std::vector<ReturnSurface> before = surfaces->surfaces;
  ParallelChunks(before.size(), 1024, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      ReturnSurface& surface = surfaces->surfaces[k];
      if (!surface.normal.isZero()) continue;
      const MapReturn& r = returns[surfaces->order[k]];
      const SurfacePlane* plane = PlaneBeside(r, *surfaces, index);
      if (plane == nullptr ||
          !PlaceOnPlane(r, *plane, surfaces->beam_spacing[r.lidar], surfaces->range_noise, &surface))
        continue;
      surface.at_edge = true;
      surface.stray = false;
    }
  });
}

}  // namespace mlic
