#include "mlic_core/crossmodal/map_surfaces.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/octree_key.h"
#include "mlic_core/geometry/plane.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

constexpr int kLevels = 5;      // splits below the root
constexpr double kRoot = 4.0;   // m
constexpr double kPatch = 0.5;  // m: larger ones are split as long as there are points
constexpr std::size_t kManyPoints = 64;
constexpr std::size_t kFewestPoints = 8;  // of a plane
// from: guard, time: cells are drawn or left out as a whole.
constexpr std::size_t kCellPoints = 256;  // of a drawn cell, more only where it is small
constexpr double kCellSize = 0.25;        // m; from: guard, time
constexpr double kFloor = 0.005;          // m: what range noise does not explain, trajectory and unevenness
constexpr double kThicknessSigmas = 1.5;
constexpr double kUnknownCosine = 0.3;
constexpr double kLine = 0.15;        // width over length below which points lie on one line of a scan
constexpr double kOneSweep = 0.15;    // s; from: derivation, between one scan and two at 10 Hz
constexpr double kLineSpacing = 0.3;  // of lines, over the widest gap between them: splats just close it
constexpr double kUnevenBeams = 2.0;  // widest gap between beams over the mean one
// from: derivation, a scan at 10 Hz.
constexpr double kDensityWindow = 0.1;  // s of beams that show how dense they are
// from: derivation, 16 rings over 30 deg are 2 deg apart.
constexpr double kWideCell = M_PI / 60.0;  // rad: wide enough that no gap between rings is seen as empty
constexpr double kDenseParent = 16.0;  // times as many points around a few as there are of them: those stray

using Voxels = Octree<16, kLevels>;

std::uint64_t VoxelKey(const Eigen::Vector3f& p) {
  const auto cell = [&](int axis) {
    return static_cast<std::int64_t>(std::floor(p[axis] * ((1 << kLevels) / kRoot)));
  };
  return Voxels::KeyOf({cell(0), cell(1), cell(2)});
}

// A beam's neighbours are no farther apart than its LiDAR's beams, however few there are; those of a single
// line of a scan (its spacing is 0) are just as far.
float SpacingOf(const SurfacePlane& plane, double beams) {
  return static_cast<float>(plane.spacing > 0.0 ? std::min(plane.spacing, beams) : kLineSpacing * beams);
}

struct PatchFit : SurfacePlane {
  bool planar = false;
  bool line = false;         // narrow: says little of the plane
  double squared_cos = 1.0;  // mean, of the incidence
};

struct Finds {
  std::vector<MapCell> cells;
  std::vector<std::uint32_t> patches;  // where they begin
  std::vector<SurfacePlane> planes;
  std::vector<double> noises;  // range noise that each large plane shows
};

// One root voxel, taken apart.
class RootVoxel {
 public:
  RootVoxel(const std::vector<MapReturn>& returns, const std::vector<KeyedIndex>& keyed,
            const std::vector<double>& beam_spacing, double range_noise, Finds* finds)
      : returns_(returns),
        keyed_(keyed),
        beam_spacing_(beam_spacing),
        range_noise_(range_noise),
        finds_(finds) {}

  void Split(std::size_t begin, std::size_t end, int level, const PatchFit& parent, bool in_cell,
             ReturnSurface* surfaces) {
    const double size = kRoot / (1 << level);
    const std::size_t count = end - begin;
    if (!in_cell && (count <= kCellPoints || size <= kCellSize)) {
      AddCell(begin, end);
      in_cell = true;
    }
    PatchFit fit = count >= 3 ? Fit(begin, end, size, level == kLevels) : parent;
    if ((count < kFewestPoints && parent.count > 0.0) || (fit.line && parent.planar))
      fit = Inherit(fit, parent);
    const bool fine_enough = size <= kPatch || count < kManyPoints;
    if (level == kLevels || count < kFewestPoints || (fit.planar && fine_enough && in_cell)) {
      finds_->patches.push_back(static_cast<std::uint32_t>(begin));
      if (fit.line && IsOneSweep(begin, end)) fit.spacing = 0.0;
      if (fit.planar) {
        finds_->planes.push_back(fit);
        finds_->planes.back().begin = static_cast<std::uint32_t>(begin);
        finds_->planes.back().end = static_cast<std::uint32_t>(end);
      }
      const bool alone = count < kFewestPoints && parent.count > kDenseParent * static_cast<double>(count);
      for (std::size_t k = begin; k < end; ++k) {
        Describe(returns_[keyed_[k].index], fit, &surfaces[k]);
        surfaces[k].stray = surfaces[k].normal.isZero() && (alone || fit.planar);
        // A few points of no plane need not be of one thing.
        if (k > begin && count < kFewestPoints && surfaces[k].normal.isZero()) {
          finds_->patches.push_back(static_cast<std::uint32_t>(k));
        }
      }
      return;
    }
    Voxels::ForEachChild(keyed_, begin, end, level, [&](std::size_t first, std::size_t last) {
      Split(first, last, level + 1, fit, in_cell, surfaces);
    });
  }

 private:
  const MapReturn& At(std::size_t k) const { return returns_[keyed_[k].index]; }

  void AddCell(std::size_t begin, std::size_t end) {
    MapCell cell;
    Eigen::AlignedBox3f box;
    for (std::size_t k = begin; k < end; ++k) box.extend(At(k).position);
    cell.center = box.center();
    cell.radius = 0.5f * box.diagonal().norm() + 0.01f;
    cell.begin = static_cast<std::uint32_t>(begin);
    cell.end = static_cast<std::uint32_t>(end);
    finds_->cells.push_back(cell);
  }

  PatchFit Fit(std::size_t begin, std::size_t end, double size, bool last) {
    const Eigen::Vector3d anchor = At(begin).position.cast<double>();
    PointCluster cluster;
    for (std::size_t k = begin; k < end; ++k) cluster.Add(At(k).position.cast<double>() - anchor);
    const SymmetricEigen<3> eigen(cluster.Covariance());
    const Eigen::Vector3d deviations = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    PatchFit fit;
    fit.count = cluster.count;
    fit.center = anchor + cluster.Mean();
    fit.normal = eigen.eigenvectors().col(0);
    fit.thickness = deviations[0];
    fit.squared_cos = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      const double cosine = At(k).beam.normalized().cast<double>().dot(fit.normal);
      fit.squared_cos += cosine * cosine / fit.count;
    }
    // A uniform rectangle's sides are sqrt(12) times its standard deviations.
    const double area = 12.0 * std::max(deviations[1], 0.02 * size) * std::max(deviations[2], 0.02 * size);
    fit.spacing = std::sqrt(std::min(area, 2.0 * size * size) / fit.count);
    const double expected = std::sqrt(fit.squared_cos * range_noise_ * range_noise_ + kFloor * kFloor);
    fit.line = deviations[1] < kLine * deviations[2];
    fit.planar = fit.count >= kFewestPoints && deviations[1] > 3.0 * deviations[0] &&
                 (deviations[0] < kThicknessSigmas * expected || last);
    if (size == kPatch && fit.count >= kManyPoints && deviations[1] > 5.0 * deviations[0] &&
        fit.squared_cos > 0.25) {
      finds_->noises.push_back(deviations[0] / std::sqrt(fit.squared_cos));
    }
    return fit;
  }

  // A voxel with few points belongs to the surface around it.
  static PatchFit Inherit(const PatchFit& few, const PatchFit& parent) {
    PatchFit fit = parent;
    if (few.count > 0.0 && !parent.planar) fit.spacing = std::max(few.spacing, parent.spacing);
    fit.line = few.line;
    return fit;
  }

  bool IsOneSweep(std::size_t begin, std::size_t end) const {
    for (std::size_t k = begin; k < end; ++k) {
      if (std::abs(At(k).time - At(begin).time) > kOneSweep) return false;
    }
    return true;
  }

  void Describe(const MapReturn& r, const PatchFit& fit, ReturnSurface* surface) const {
    surface->position = r.position;
    surface->normal.setZero();
    const double range = r.beam.norm(), beams = beam_spacing_[r.lidar] * range;
    surface->spacing = SpacingOf(fit, beams);
    // A beam's light on the surface covers an area that grows with range squared over cosine.
    surface->weight = static_cast<float>(std::sqrt(kUnknownCosine / (1.0 + range * range)));
    if (fit.planar) PlaceOnPlane(r, fit, beam_spacing_[r.lidar], range_noise_, surface);
  }

  const std::vector<MapReturn>& returns_;
  const std::vector<KeyedIndex>& keyed_;
  const std::vector<double>& beam_spacing_;  // rad, of each LiDAR
  double range_noise_;
  Finds* finds_;
};

// Angles between neighbouring beams of each LiDAR, rad: the solid angle that the beams of a short time cover,
// over their number; the middle of some such times.
std::vector<double> BeamSpacings(const std::vector<MapReturn>& returns) {
  constexpr std::size_t kWindows = 15;       // from: guard, time
  constexpr int kColumns = 120, kRows = 60;  // from: structural, cells of kWideCell over the sphere
  std::vector<std::vector<double>> found;
  for (std::size_t begin = 0; begin < returns.size();) {
    const std::size_t lidar = returns[begin].lidar;
    std::size_t end = begin;
    while (end < returns.size() && returns[end].lidar == lidar) ++end;
    if (found.size() <= lidar) found.resize(lidar + 1);
    for (std::size_t w = 0; w < kWindows; ++w) {
      std::vector<bool> covered(kColumns * kRows, false);
      double solid_angle = 0.0, count = 0.0;
      const std::size_t first = begin + (end - begin) * w / kWindows;
      for (std::size_t i = first; i < end && std::abs(returns[i].time - returns[first].time) < kDensityWindow;
           ++i) {
        const Eigen::Vector3f d = returns[i].beam.normalized();
        const int column = static_cast<int>((std::atan2(d.y(), d.x()) + M_PI) / kWideCell) % kColumns;
        const int row =
            std::clamp(static_cast<int>((std::asin(d.z()) + 0.5 * M_PI) / kWideCell), 0, kRows - 1);
        if (!covered[row * kColumns + column]) {
          solid_angle += kWideCell * kWideCell * std::cos((row + 0.5) * kWideCell - 0.5 * M_PI);
        }
        covered[row * kColumns + column] = true;
        count += 1.0;
      }
      if (count > 0.0) found[lidar].push_back(std::sqrt(solid_angle / count));
    }
    begin = end;
  }
  std::vector<double> spacings;
  for (auto& of_lidar : found) spacings.push_back(of_lidar.empty() ? kWideCell : Median(std::move(of_lidar)));
  return spacings;
}

}  // namespace

double NoiseOffPlane(double cosine, double range_noise) {
  return std::sqrt(cosine * cosine * range_noise * range_noise + kFloor * kFloor);
}

bool PlaceOnPlane(const MapReturn& r, const SurfacePlane& plane, double beam_spacing, double range_noise,
                  ReturnSurface* surface) {
  const double range = r.beam.norm();
  const Eigen::Vector3d direction = r.beam.cast<double>() / range;
  const double cosine = plane.normal.dot(direction);
  const double distance = plane.normal.dot(r.position.cast<double>() - plane.center);
  if (std::abs(distance) > 3.0 * std::max(NoiseOffPlane(cosine, range_noise), plane.thickness)) return false;
  const double beams = beam_spacing * range / std::max(0.1, std::abs(cosine));
  surface->spacing = SpacingOf(plane, kUnevenBeams * beams);
  // A beam's light on the surface covers an area that grows with range squared over cosine.
  surface->weight = static_cast<float>(std::sqrt(std::max(0.02, std::abs(cosine)) / (1.0 + range * range)));
  surface->normal = ((cosine > 0.0 ? -1.0 : 1.0) * plane.normal).cast<float>();
  const double plane_sigma = plane.thickness / std::sqrt(plane.count) + kFloor;
  const double noise = range_noise * range_noise * cosine * cosine;
  const double step =
      distance * cosine / (cosine * cosine + 1e-6) * noise / (noise + plane_sigma * plane_sigma);
  surface->position = (r.position.cast<double>() - step * direction).cast<float>();
  return true;
}

MapSurfaces FindSurfaces(const std::vector<MapReturn>& returns) {
  std::vector<KeyedIndex> keyed(returns.size());
  ParallelChunks(returns.size(), 256, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      keyed[i] = {VoxelKey(returns[i].position), static_cast<std::uint32_t>(i)};
    }
  });
  tbb::parallel_sort(keyed.begin(), keyed.end());
  std::vector<std::size_t> roots;
  for (std::size_t k = 0; k < keyed.size(); ++k) {
    if (k == 0 || Voxels::RootOf(keyed[k].key) != Voxels::RootOf(keyed[k - 1].key)) roots.push_back(k);
  }
  roots.push_back(keyed.size());

  MapSurfaces result;
  result.beam_spacing = BeamSpacings(returns);
  result.surfaces.resize(keyed.size());
  result.range_noise = 0.02;
  std::vector<Finds> finds;
  // The first pass measures the noise that the second one's planes are judged by.
  for (int pass = 0; pass < 2; ++pass) {
    finds.assign(roots.size() - 1, {});
    ParallelFor(finds.size(), [&](std::size_t v) {
      if (pass == 0 && v % 8 != 0) return;
      RootVoxel(returns, keyed, result.beam_spacing, result.range_noise, &finds[v])
          .Split(roots[v], roots[v + 1], 0, {}, false, result.surfaces.data());
    });
    if (pass == 1) break;
    std::vector<double> noises;
    for (const Finds& f : finds) noises.insert(noises.end(), f.noises.begin(), f.noises.end());
    result.range_noise = std::clamp(noises.empty() ? 0.02 : Median(std::move(noises)), 0.003, 0.1);
  }
  for (const Finds& f : finds) {
    result.cells.insert(result.cells.end(), f.cells.begin(), f.cells.end());
    result.patches.insert(result.patches.end(), f.patches.begin(), f.patches.end());
    result.planes.insert(result.planes.end(), f.planes.begin(), f.planes.end());
  }
  result.patches.push_back(static_cast<std::uint32_t>(keyed.size()));
  result.order.reserve(keyed.size());
  for (const KeyedIndex& k : keyed) result.order.push_back(k.index);
  return result;
}

}  // namespace mlic
