#include "mlic_core/lidar/voxel_hash_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace mlic {
namespace {

constexpr double kFewestForPlane = 6.0;  // from: measured, drift of simulated drives by hand and car
// from: measured, drift of simulated drives by hand and car.
constexpr double kMostPoints =
    500.0;  // then a voxel is known well; later points would smear it with the drift
// Points that a voxel's extent counts like.
constexpr double kScatterPrior = 10.0;      // from: measured, scans lost of narrow LiDARs on slopes
constexpr double kGrowthBeforeRefit = 1.3;  // from: guard, time
// from: measured, drift of simulated drives by hand and car.
constexpr double kThickestPlane = 0.06;  // m, standard deviation: sensor noise and what de-skew leaves
// from: measured, drift of simulated drives by hand and car.
constexpr double kFlatness = 0.04;  // smallest to middle eigenvalue
// from: measured, drift of simulated drives by hand and car.
constexpr double kNarrowestPlane =
    0.12;  // standard deviation across the plane, in voxels: no single scan line

std::uint64_t Key(const Eigen::Vector3d& point, double inverse_voxel) {
  // from: structural.
  constexpr double kShift = 1048576.0;  // 2^20: non-negative numbers for 1e6 voxels each way
  const auto number = [&](double x) {
    return static_cast<std::uint64_t>(std::floor(x * inverse_voxel) + kShift) & 0x1FFFFFu;
  };
  return number(point.x()) | (number(point.y()) << 21) | (number(point.z()) << 42);
}

Eigen::Vector3d CenterOf(const Eigen::Vector3d& point, double voxel) {
  return ((point / voxel).array().floor() + 0.5) * voxel;
}

}  // namespace

VoxelHashMap::VoxelHashMap(double largest_voxel) {
  for (Level& level : levels_) {
    level.voxel = largest_voxel;
    largest_voxel *= 0.5;
  }
}

void VoxelHashMap::Add(const std::vector<Eigen::Vector3d>& points) {
  for (Level& level : levels_) level.Add(points);
}

const Surface* VoxelHashMap::Find(const Eigen::Vector3d& point) const {
  const Surface* scatter = nullptr;
  for (const Level& level : levels_) {
    const Surface* surface = level.Find(point);
    if (surface == nullptr) continue;
    if (surface->kind == Surface::Kind::kPlane) return surface;
    if (surface->kind == Surface::Kind::kScatter) scatter = surface;
  }
  for (const Level& level : levels_) {
    const Surface* surface = level.FindAcrossNearestFace(point);
    if (surface != nullptr && surface->kind == Surface::Kind::kPlane) return surface;
  }
  return scatter;
}

void VoxelHashMap::RemoveFarFrom(const Eigen::Vector3d& center, double radius) {
  for (Level& level : levels_) level.RemoveFarFrom(center, radius);
}

std::size_t VoxelHashMap::size() const {
  std::size_t sum = 0;
  for (const Level& level : levels_) sum += level.surfaces.size();
  return sum;
}

void VoxelHashMap::Level::Add(const std::vector<Eigen::Vector3d>& points) {
  const double inverse_voxel = 1.0 / voxel;
  std::vector<std::uint32_t> touched;
  touched.reserve(points.size());
  for (const Eigen::Vector3d& point : points) {
    const auto [entry, is_new] =
        index.try_emplace(Key(point, inverse_voxel), static_cast<std::uint32_t>(surfaces.size()));
    const std::uint32_t i = entry->second;
    if (is_new) {
      surfaces.emplace_back();
      clusters.emplace_back();
      centers.push_back(CenterOf(point, voxel));
    }
    if (clusters[i].count >= kMostPoints) continue;
    clusters[i].Add(point - centers[i]);
    touched.push_back(i);
  }
  for (const std::uint32_t i : touched) {
    if (clusters[i].count > kGrowthBeforeRefit * surfaces[i].fitted_count) Fit(i);
  }
}

void VoxelHashMap::Level::Fit(std::uint32_t voxel_index) {
  const PointCluster& cluster = clusters[voxel_index];
  Surface& surface = surfaces[voxel_index];
  surface.fitted_count = static_cast<std::uint32_t>(cluster.count);
  surface.mean = centers[voxel_index] + cluster.Mean();
  surface.kind = Surface::Kind::kScatter;
  const double all_over = 0.1 * voxel * voxel;  // about the variance of points all over a voxel
  surface.axes.setIdentity();
  surface.variances.setConstant(all_over);
  if (cluster.count < kFewestForPlane) return;

  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(cluster.Covariance());
  const Eigen::Vector3d& values = solver.eigenvalues();
  const double smallest = std::max(0.0, values[0]);
  surface.axes = solver.eigenvectors();
  // A few points may lie on one line by chance.
  surface.variances = (cluster.count * values.cwiseMax(0.0).array() + kScatterPrior * all_over) /
                      (cluster.count + kScatterPrior);
  const double narrowest = kNarrowestPlane * voxel;
  if (smallest <= kThickestPlane * kThickestPlane && smallest <= kFlatness * values[1] &&
      values[1] >= narrowest * narrowest) {
    surface.kind = Surface::Kind::kPlane;
    surface.normal = solver.eigenvectors().col(0);
    surface.variance = smallest;
  }
}

const Surface* VoxelHashMap::Level::Find(const Eigen::Vector3d& point) const {
  const auto entry = index.find(Key(point, 1.0 / voxel));
  return entry == index.end() ? nullptr : &surfaces[entry->second];
}

const Surface* VoxelHashMap::Level::FindAcrossNearestFace(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d from_center = point - CenterOf(point, voxel);
  Eigen::Index axis = 0;
  from_center.cwiseAbs().maxCoeff(&axis);
  Eigen::Vector3d neighbor = point;
  neighbor[axis] += from_center[axis] > 0.0 ? voxel : -voxel;
  return Find(neighbor);
}

void VoxelHashMap::Level::RemoveFarFrom(const Eigen::Vector3d& center, double radius) {
  Level kept;
  kept.voxel = voxel;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if ((centers[i] - center).squaredNorm() > radius * radius) continue;
    kept.index.emplace(Key(centers[i], 1.0 / voxel), static_cast<std::uint32_t>(kept.surfaces.size()));
    kept.surfaces.push_back(surfaces[i]);
    kept.clusters.push_back(clusters[i]);
    kept.centers.push_back(centers[i]);
  }
  *this = std::move(kept);
}

}  // namespace mlic
