#pragma once

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "mlic_sim/lighting.h"
#include "mlic_sim/world.h"

namespace mlic::sim {

// Constants of this file, from: structural.

// The light that the world's surfaces send out, as textures with levels of detail. Nothing moves and surfaces
// are Lambertian, so that it does not depend on the view: texels (albedo, sun, shadows, sky) are computed
// once, tile by tile when first looked at, and pictures cost little more than their rays. A tile is a pure
// function of its place, so the outcome does not depend on who asks first. Thread-safe.
class SurfaceTextures {
 public:
  SurfaceTextures(const World& world, const Lighting& lighting);
  ~SurfaceTextures();
  SurfaceTextures(const SurfaceTextures&) = delete;
  SurfaceTextures& operator=(const SurfaceTextures&) = delete;

  // Linear red, green, blue at place p (m, map frame) of a triangle seen along `direction` (unit), averaged
  // over about `footprint` (m, across the ray).
  Eigen::Vector3f Radiance(std::uint32_t triangle, const Eigen::Vector3f& p, const Eigen::Vector3f& direction,
                           float footprint) const;

 private:
  static constexpr int kLevels = 11;  // texels of 2^-8 m and twice as large at each level
  static constexpr float kFinest = 0.00390625f;
  static constexpr int kTile = 32;           // texels along a tile's edge
  static constexpr int kStride = kTile + 1;  // with a border for the interpolation

  using Texel = std::array<std::uint16_t, 4>;
  class TileLight;
  struct Tile {
    std::array<Texel, kStride * kStride> texels;
  };
  // One side of a flat surface (or of the ground, which is seen from above): triangles that lie in one plane.
  struct Surface {
    Eigen::Vector3f origin, u, v, normal;
    float width = 0.0f, height = 0.0f;  // m
    Material material = Material::kConcrete;
    std::uint32_t object = 0;
    bool ground = false;
    std::array<std::uint32_t, kLevels>
        first_tile{};  // of the front side; the back side's follow all of these
    std::array<std::uint16_t, kLevels> columns{};
    std::uint32_t back_side = 0;  // added to a tile's index
  };

  void AddSurfaces();
  void PlaceTiles();
  const Tile& TileAt(const Surface& surface, bool back, int level, int column, int row) const;
  Eigen::Array4f Lookup(const Surface& surface, bool back, int level, float u, float v) const;
  std::unique_ptr<Tile> Bake(const Surface& surface, bool back, int level, int column, int row) const;

  const World& world_;
  Lighting lighting_;
  std::vector<Surface> surfaces_;
  std::vector<std::uint32_t> surface_of_triangle_;
  std::size_t tile_count_ = 0;
  std::unique_ptr<std::atomic<Tile*>[]> tiles_;
};

}  // namespace mlic::sim
