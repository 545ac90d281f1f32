#pragma once

#include <tsl/robin_map.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "mlic_core/geometry/plane.h"

namespace mlic {

// What the map knows of the surface in one voxel.
struct Surface {
  enum class Kind : std::uint8_t { kUnknown, kPlane, kScatter };
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // kPlane
  double variance = 0.0;                             // m^2, of the points along the normal; kPlane
  // kScatter: principal directions of the points (columns) and the variances along them, m^2.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d variances = Eigen::Vector3d::Zero();
  Kind kind = Kind::kUnknown;
  std::uint32_t fitted_count = 0;  // points the fit stands on
};

// Map of points as the moments of the points of each voxel, at three voxel sizes. A surface is taken from the
// largest voxel that is flat: many points make a good plane; where the world is more detailed, smaller voxels
// describe it. Frame: odometry's. Not safe for calls from several threads at once.
class VoxelHashMap {
 public:
  // largest_voxel: m. The others are a half and a quarter of it.
  explicit VoxelHashMap(double largest_voxel);

  void Add(const std::vector<Eigen::Vector3d>& points);

  // The surface a point near it belongs to: the plane of the largest flat voxel around the point, or else of
  // the next voxel across the nearest voxel face, or else the scatter of the smallest voxel. nullptr where
  // there is nothing.
  const Surface* Find(const Eigen::Vector3d& point) const;

  // Forgets what is farther from the center than the radius.
  void RemoveFarFrom(const Eigen::Vector3d& center, double radius);

  std::size_t size() const;

 private:
  struct KeyHash {
    std::size_t operator()(std::uint64_t key) const {
      key *= 0x9E3779B97F4A7C15ull;
      return key ^ (key >> 32);
    }
  };
  struct Level {
    double voxel = 1.0;
    tsl::robin_map<std::uint64_t, std::uint32_t, KeyHash> index;
    std::vector<Surface> surfaces;
    std::vector<PointCluster> clusters;  // anchored at the voxel's center
    std::vector<Eigen::Vector3d> centers;

    void Add(const std::vector<Eigen::Vector3d>& points);
    void Fit(std::uint32_t voxel_index);
    const Surface* Find(const Eigen::Vector3d& point) const;
    const Surface* FindAcrossNearestFace(const Eigen::Vector3d& point) const;
    void RemoveFarFrom(const Eigen::Vector3d& center, double radius);
  };
  std::array<Level, 3> levels_;  // largest voxels first
};

}  // namespace mlic
