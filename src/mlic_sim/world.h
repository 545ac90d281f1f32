#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "mlic_sim/mesh.h"
#include "mlic_sim/moving_objects.h"
#include "mlic_sim/ray_hit.h"

namespace mlic::sim {

// Rays that are cast together, for pictures: single precision is good to some micrometres at 50 m, far below
// a pixel.
struct RayPacket {
  static constexpr int kSize = 8;  // from: structural
  alignas(32) float origin[3][kSize];
  alignas(32) float direction[3][kSize];
  alignas(32) int valid[kSize];  // -1: cast, 0: leave out
  // Results: infinity where nothing was hit, and then no triangle.
  alignas(32) float range[kSize];
  std::uint32_t triangle[kSize];  // index in Mesh::triangles
};

// A world that can be ray-cast (Embree), with the few things that move in it. Thread-safe once built.
class World {
 public:
  explicit World(Mesh mesh, InfraredLook infrared = InfraredLook::kRelated, MovingObjects moving = {});
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // The first surface along the ray, or nothing within max_range (m). direction: unit. Embree's single
  // precision only picks the triangle: range and position come from the triangle's plane in double precision.
  std::optional<RayHit> Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                             double max_range) const;

  // The same with what moves, as it is at `time` (s).
  std::optional<RayHit> CastAt(double time, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                               double max_range) const;

  // Neighbouring rays of one picture, of what stands still.
  void CastPacket(float max_range, RayPacket& packet) const;

  // Whether anything lies within max_range (m) along the ray.
  bool IsOccluded(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float max_range) const;

  const Mesh& mesh() const { return mesh_; }
  InfraredLook infrared() const { return infrared_; }
  const MovingObjects& moving() const { return moving_; }

 private:
  struct Embree;
  Mesh mesh_;
  InfraredLook infrared_;
  MovingObjects moving_;
  std::unique_ptr<Embree> embree_;
};

}  // namespace mlic::sim
