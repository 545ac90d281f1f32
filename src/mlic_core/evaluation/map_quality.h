#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

struct MapEntropyOptions {
  double radius = 0.3;  // m, neighbourhood of a point; from: definition of the figure of merit
  // from: definition of the figure of merit.
  std::size_t fewest_neighbours = 10;  // points with fewer say nothing
  // from: guard, time.
  std::size_t most_queries = 30000;  // evenly chosen points at which the entropy is taken
};

struct MapEntropy {
  double mean = 0.0;             // nats; lower is crisper
  std::size_t queries_used = 0;  // points with enough neighbours
};

// Mean map entropy: 0.5 * ln det(2 pi e Sigma) of the neighbours of each point, averaged (Droeschel and
// Behnke, ICRA 2018). Compare maps of the same scans only. lidar: an index of MapPoint::lidar, or -1 for all
// points together.
MapEntropy MeanMapEntropy(const std::vector<MapPoint>& points, int lidar, const MapEntropyOptions& options);

// How well two LiDARs' points lie on each other, over the planes that both see.
struct OverlapThickness {
  int lidar_a = 0, lidar_b = 0;  // indices of MapPoint::lidar
  double thickness = 0.0;        // rms distance of both LiDARs' points from their common plane, m
  double separation = 0.0;       // rms distance between the two LiDARs' own centres along the normal, m
  std::size_t planes = 0;
};

// One entry for each pair of LiDARs that share at least one plane with `fewest_points` points of each. Every
// plane counts alike, so that a large ground does not hide the walls. Points without a plane are left out.
std::vector<OverlapThickness> OverlapThicknesses(const std::vector<MapPoint>& points,
                                                 std::size_t fewest_points = 15);

// Sets MapPoint::plane anew: points of one cube of `voxel` metres belong to one plane if they are flat
// (thickness below `largest_thickness`, a fifth of the extent at most), else to none. For maps that come
// without planes. A wall that a face of the cubes cuts lengthwise counts as two thinner ones, so thicknesses
// come out a little low.
void AssignVoxelPlanes(double voxel, double largest_thickness, std::vector<MapPoint>* points);

}  // namespace mlic
