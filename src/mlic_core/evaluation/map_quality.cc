#include "mlic_core/evaluation/map_quality.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "mlic_core/common/parallel.h"
#include "mlic_core/evaluation/voxel_index.h"
#include "mlic_core/geometry/plane.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

// Entropy of the neighbours of one point; NaN when they are too few or have no volume.
double EntropyAt(const std::vector<MapPoint>& points, const VoxelIndex& index, const Eigen::Vector3f& query,
                 const MapEntropyOptions& options) {
  PointCluster cluster;
  const float radius_squared = static_cast<float>(options.radius * options.radius);
  const Eigen::Vector3i center = index.CellOf(query);
  for (int n = 0; n < 27; ++n) {
    const auto* cell = index.Find(center + Eigen::Vector3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
    if (cell == nullptr) continue;
    for (const std::uint32_t i : *cell) {
      const Eigen::Vector3f difference = points[i].position - query;
      if (difference.squaredNorm() <= radius_squared) cluster.Add(difference.cast<double>().eval());
    }
  }
  if (cluster.count < static_cast<double>(options.fewest_neighbours)) return std::nan("");
  const double determinant = (2.0 * M_PI * std::exp(1.0) * cluster.Covariance()).determinant();
  return determinant > 0.0 ? 0.5 * std::log(determinant) : std::nan("");
}

// Spread of a cluster along its thinnest direction.
double ThicknessOf(const SymmetricEigen<3>& solver) {
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
}

}  // namespace

MapEntropy MeanMapEntropy(const std::vector<MapPoint>& points, int lidar, const MapEntropyOptions& options) {
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (lidar < 0 || points[i].lidar == lidar) chosen.push_back(i);
  }
  const VoxelIndex index(points, chosen, options.radius);
  const std::size_t count = std::min(options.most_queries, chosen.size());
  std::vector<double> entropies(count);
  ParallelFor(count, [&](std::size_t q) {
    entropies[q] = EntropyAt(points, index, points[chosen[q * chosen.size() / count]].position, options);
  });
  MapEntropy result;
  for (const double entropy : entropies) {
    if (std::isnan(entropy)) continue;
    result.mean += entropy;
    ++result.queries_used;
  }
  result.mean =
      result.queries_used > 0 ? result.mean / static_cast<double>(result.queries_used) : std::nan("");
  return result;
}

std::vector<OverlapThickness> OverlapThicknesses(const std::vector<MapPoint>& points,
                                                 std::size_t fewest_points) {
  // Clusters about the first point of each plane, so that coordinates of kilometres cost no digits.
  std::map<int, Eigen::Vector3d> anchors;
  std::map<int, std::map<int, PointCluster>> planes;
  for (const MapPoint& point : points) {
    if (point.plane < 0) continue;
    const Eigen::Vector3d position = point.position.cast<double>();
    const Eigen::Vector3d& anchor = anchors.emplace(point.plane, position).first->second;
    planes[point.plane][point.lidar].Add(position - anchor);
  }
  std::map<std::pair<int, int>, OverlapThickness> pairs;
  for (const auto& [plane, lidars] : planes) {
    for (auto a = lidars.begin(); a != lidars.end(); ++a) {
      for (auto b = std::next(a); b != lidars.end(); ++b) {
        if (std::min(a->second.count, b->second.count) < static_cast<double>(fewest_points)) continue;
        PointCluster both = a->second;
        both.Add(b->second);
        const SymmetricEigen<3> solver(both.Covariance());
        const double thickness = ThicknessOf(solver);
        const double separation = solver.eigenvectors().col(0).dot(a->second.Mean() - b->second.Mean());
        OverlapThickness& pair = pairs[{a->first, b->first}];
        pair.thickness += thickness * thickness;
        pair.separation += separation * separation;
        ++pair.planes;
      }
    }
  }
  std::vector<OverlapThickness> result;
  for (auto& [lidars, pair] : pairs) {
    pair.lidar_a = lidars.first;
    pair.lidar_b = lidars.second;
    pair.thickness = std::sqrt(pair.thickness / static_cast<double>(pair.planes));
    pair.separation = std::sqrt(pair.separation / static_cast<double>(pair.planes));
    result.push_back(pair);
  }
  return result;
}

void AssignVoxelPlanes(double voxel, double largest_thickness, std::vector<MapPoint>* points) {
  std::vector<std::uint32_t> all(points->size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  const VoxelIndex index(*points, all, voxel);
  // Cells in the order of their first point: the same numbers from every standard library's hash.
  std::vector<const std::vector<std::uint32_t>*> cells;
  for (const auto& cell : index.Cells()) cells.push_back(&cell.second);
  std::sort(cells.begin(), cells.end(), [](const auto* a, const auto* b) { return a->front() < b->front(); });
  int next_plane = 0;
  for (const auto* cell : cells) {
    PointCluster cluster;
    const Eigen::Vector3f anchor = (*points)[cell->front()].position;
    for (const std::uint32_t i : *cell) cluster.Add(((*points)[i].position - anchor).cast<double>().eval());
    const SymmetricEigen<3> solver(cluster.Covariance());
    const double thickness = ThicknessOf(solver);
    const bool flat = cell->size() >= 10 && thickness < largest_thickness &&
                      thickness < 0.2 * std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
    for (const std::uint32_t i : *cell) (*points)[i].plane = flat ? next_plane : -1;
    if (flat) ++next_plane;
  }
}

}  // namespace mlic
