#include "mlic_sim/surface_textures.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_sim/procedural_noise.h"

namespace mlic::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kFullScale = 1.0f / 16384.0f;  // radiance of one count; from: structural

std::array<Vector3f, 3> Corners(const Mesh& mesh, const Triangle& t) {
  return {mesh.vertices()[t.vertices[0]], mesh.vertices()[t.vertices[1]], mesh.vertices()[t.vertices[2]]};
}

// The four counts as numbers.
Eigen::Array4f Widened(const std::array<std::uint16_t, 4>& texel) {
  Eigen::Array4f widened;
#ifdef __SSE2__
  // All at once: one by one, the conversions cost more than the rest of a look-up.
  const __m128i counts = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(texel.data()));
  _mm_store_ps(widened.data(), _mm_cvtepi32_ps(_mm_unpacklo_epi16(counts, _mm_setzero_si128())));
#else
  for (int c = 0; c < 4; ++c) widened[c] = texel[static_cast<std::size_t>(c)];
#endif
  return widened;
}

}  // namespace

SurfaceTextures::SurfaceTextures(const World& world, const Lighting& lighting)
    : world_(world), lighting_(lighting) {
  AddSurfaces();
  PlaceTiles();
}

SurfaceTextures::~SurfaceTextures() {
  for (std::size_t i = 0; i < tile_count_; ++i) delete tiles_[i].load();
}

void SurfaceTextures::AddSurfaces() {
  const Mesh& mesh = world_.mesh();
  surface_of_triangle_.reserve(mesh.triangles().size());
  std::uint32_t ground = 0;
  bool has_ground = false;
  for (const Triangle& t : mesh.triangles()) {
    const auto corners = Corners(mesh, t);
    const bool is_ground = IsGround(t.material);
    if (is_ground && has_ground) {
      surface_of_triangle_.push_back(ground);
    } else {
      Surface s;
      s.material = t.material, s.object = t.object, s.ground = is_ground;
      s.normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
      const bool same_plane = !surfaces_.empty() && !is_ground && surfaces_.back().material == s.material &&
                              surfaces_.back().object == s.object &&
                              s.normal.dot(surfaces_.back().normal) > 0.999999f &&
                              std::abs(s.normal.dot(corners[0] - surfaces_.back().origin)) < 1e-4f;
      if (!same_plane) {
        s.u = is_ground ? Vector3f::UnitX().eval() : (corners[1] - corners[0]).normalized().eval();
        s.v = is_ground ? Vector3f::UnitY().eval() : s.normal.cross(s.u).eval();
        if (is_ground) s.normal = Vector3f::UnitZ();
        s.origin = corners[0];
        surfaces_.push_back(s);
        if (is_ground) ground = static_cast<std::uint32_t>(surfaces_.size() - 1), has_ground = true;
      }
      surface_of_triangle_.push_back(static_cast<std::uint32_t>(surfaces_.size() - 1));
    }
    Surface& s = surfaces_[surface_of_triangle_.back()];
    // The origin moves to the lower left corner of all triangles so far.
    for (const Vector3f& corner : corners) {
      const float u = s.u.dot(corner - s.origin), v = s.v.dot(corner - s.origin);
      if (u < 0.0f) s.origin += u * s.u, s.width -= u;
      if (v < 0.0f) s.origin += v * s.v, s.height -= v;
      s.width = std::max(s.width, u), s.height = std::max(s.height, v);
    }
  }
}

void SurfaceTextures::PlaceTiles() {
  std::uint32_t next = 0;
  for (Surface& s : surfaces_) {
    const std::uint32_t begin = next;
    for (int level = 0; level < kLevels; ++level) {
      const float tile = kFinest * static_cast<float>(kTile << level);
      const auto columns = static_cast<std::uint32_t>(s.width / tile) + 1;
      const auto rows = static_cast<std::uint32_t>(s.height / tile) + 1;
      s.first_tile[level] = next;
      s.columns[level] = static_cast<std::uint16_t>(columns);
      next += columns * rows;
    }
    s.back_side = next - begin;
    next += s.back_side;
  }
  tile_count_ = next;
  tiles_.reset(new std::atomic<Tile*>[tile_count_]());
}

Vector3f SurfaceTextures::Radiance(std::uint32_t triangle, const Vector3f& p, const Vector3f& direction,
                                   float footprint) const {
  const Surface& s = surfaces_[surface_of_triangle_[triangle]];
  const float along = s.normal.dot(direction);
  const bool back = along > 0.0f;
  const float slant = std::max(0.04f, std::abs(along));
  // A slanted view stretches the footprint along the ray: several texels side by side, somewhat larger ones.
  const int taps = slant > 0.5f ? 1 : slant > 0.25f ? 2 : 4;
  const float size = std::max(footprint, footprint / (slant * static_cast<float>(taps)));
  const float detail = std::clamp(std::log2(size / kFinest), 0.0f, kLevels - 1.001f);
  const int level = static_cast<int>(detail);
  const float blend = detail - static_cast<float>(level);
  const Vector3f relative = p - s.origin;
  const float u = s.u.dot(relative), v = s.v.dot(relative);
  const float du = s.u.dot(direction) / slant * footprint / static_cast<float>(taps);
  const float dv = s.v.dot(direction) / slant * footprint / static_cast<float>(taps);
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int tap = 0; tap < taps; ++tap) {
    const float at = static_cast<float>(tap) - 0.5f * static_cast<float>(taps - 1);
    Eigen::Array4f color = Lookup(s, back, level, u + at * du, v + at * dv);
    if (blend > 0.05f) color += blend * (Lookup(s, back, level + 1, u + at * du, v + at * dv) - color);
    sum += color;
  }
  return sum.head<3>().matrix() * (kFullScale / static_cast<float>(taps));
}

const SurfaceTextures::Tile& SurfaceTextures::TileAt(const Surface& s, bool back, int level, int column,
                                                     int row) const {
  const std::size_t index = s.first_tile[level] + (back ? s.back_side : 0) +
                            static_cast<std::size_t>(row) * s.columns[level] +
                            static_cast<std::size_t>(column);
  Tile* tile = tiles_[index].load(std::memory_order_acquire);
  if (tile == nullptr) {
    std::unique_ptr<Tile> baked = Bake(s, back, level, column, row);
    if (tiles_[index].compare_exchange_strong(tile, baked.get(), std::memory_order_acq_rel))
      tile = baked.release();
  }
  return *tile;
}

Eigen::Array4f SurfaceTextures::Lookup(const Surface& s, bool back, int level, float u, float v) const {
  // Texel i is the mean about the place i * size; tile c holds the texels from kTile c to kTile (c + 1), both
  // ends included. The sizes are powers of two, so that their inverses are exact.
  const float texels = 1.0f / (kFinest * static_cast<float>(1 << level));
  const float x = std::clamp(u, 0.0f, s.width) * texels, y = std::clamp(v, 0.0f, s.height) * texels;
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const int column = i / kTile, row = j / kTile;
  const Texel* t = &TileAt(s, back, level, column, row)
                        .texels[static_cast<std::size_t>((j - row * kTile) * kStride + (i - column * kTile))];
  const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
  return (1 - a) * (1 - b) * Widened(t[0]) + a * (1 - b) * Widened(t[1]) + (1 - a) * b * Widened(t[kStride]) +
         a * b * Widened(t[kStride + 1]);
}

// What the texels of one tile are computed from: places on the surface, and the light that falls there. Light
// from all around is smooth and interpolated from a coarse grid; the sun's (the lamps') is interpolated
// within cells whose corners agree about the shadow, and cast anew where they do not.
class SurfaceTextures::TileLight {
 public:
  TileLight(const SurfaceTextures& textures, const Surface& s, bool back, int level, int column, int row)
      : world_(textures.world_), lighting_(textures.lighting_), s_(s), level_(level) {
    size_ = kFinest * static_cast<float>(1 << level);
    u0_ = static_cast<float>(column * kTile) * size_, v0_ = static_cast<float>(row * kTile) * size_;
    normal_ = back ? Vector3f(-s.normal) : s.normal;
    columns = std::min(kStride, static_cast<int>((s.width - u0_) / size_) + 2);
    rows = std::min(kStride, static_cast<int>((s.height - v0_) / size_) + 2);
    if (s.ground) {
      for (int k = 0; k < 4; ++k) height_[k] = GroundHeight(k % 2 * kTile, k / 2 * kTile);
    }
    around_ = MakeGrid(level <= 1   ? 16
                       : level <= 3 ? 8
                                    : 4,
                       [&](const Vector3f& p) { return AmbientLight(world_, lighting_, p, normal_); });
    direct_ = MakeGrid(level <= 2 ? 4 : 1,
                       [&](const Vector3f& p) { return DirectLight(world_, lighting_, p, normal_); });
  }

  // Places are in texels from the tile's corner.
  Vector3f Place(float x, float y) const {
    const float u = std::clamp(u0_ + x * size_, 0.0f, s_.width),
                v = std::clamp(v0_ + y * size_, 0.0f, s_.height);
    Vector3f p = s_.origin + u * s_.u + v * s_.v;
    if (s_.ground) {
      const float a = x / kTile, b = y / kTile;
      p.z() = level_ <= 3 ? (1 - b) * ((1 - a) * height_[0] + a * height_[1]) +
                                b * ((1 - a) * height_[2] + a * height_[3])
                          : GroundHeight(x, y);
    }
    return p;
  }

  Vector3f At(float x, float y, const Vector3f& p) const {
    Vector3f ambient, direct;
    around_.Interpolate(x, y, &ambient);
    if (!direct_.Interpolate(x, y, &direct)) direct = DirectLight(world_, lighting_, p, normal_);
    return ambient + direct;
  }

  int columns, rows;  // of the texels that matter: those on the surface and one more for the interpolation

 private:
  struct Grid {
    int step, columns, rows;
    std::vector<Vector3f> nodes;

    // False where the corners of the cell differ much.
    bool Interpolate(float x, float y, Vector3f* value) const {
      const float gx = std::max(0.0f, x / static_cast<float>(step)),
                  gy = std::max(0.0f, y / static_cast<float>(step));
      const int i = std::min(columns - 2, static_cast<int>(gx)), j = std::min(rows - 2, static_cast<int>(gy));
      const float a = gx - static_cast<float>(i), b = gy - static_cast<float>(j);
      const Vector3f* n = &nodes[static_cast<std::size_t>(j * columns + i)];
      *value = (1 - b) * ((1 - a) * n[0] + a * n[1]) + b * ((1 - a) * n[columns] + a * n[columns + 1]);
      const float low = std::min(std::min(n[0].y(), n[1].y()), std::min(n[columns].y(), n[columns + 1].y()));
      const float high = std::max(std::max(n[0].y(), n[1].y()), std::max(n[columns].y(), n[columns + 1].y()));
      return high - low < 0.02f;
    }
  };

  template <typename Light>
  Grid MakeGrid(int step, const Light& light) const {
    Grid grid{step, (columns - 2) / step + 2, (rows - 2) / step + 2, {}};
    for (int j = 0; j < grid.rows; ++j) {
      for (int i = 0; i < grid.columns; ++i) {
        grid.nodes.push_back(light(Place(static_cast<float>(i * step), static_cast<float>(j * step))));
      }
    }
    return grid;
  }

  float GroundHeight(float x, float y) const {
    const Vector3f p = s_.origin + (u0_ + x * size_) * s_.u + (v0_ + y * size_) * s_.v;
    // The yard's ground is level but for millimetres.
    const auto& ground = world_.mesh().ground_height();
    const double about = ground && s_.material != Material::kYardGround ? ground(p.x(), p.y()) : 0.0;
    const auto hit = world_.Cast(Vector3d(p.x(), p.y(), about + 0.05), -Vector3d::UnitZ(), 1.0);
    return hit ? static_cast<float>(hit->position.z()) : static_cast<float>(about);
  }

  const World& world_;
  const Lighting& lighting_;
  const Surface& s_;
  int level_;
  float size_, u0_, v0_;
  Vector3f normal_;
  std::array<float, 4> height_{};
  Grid around_, direct_;
};

std::unique_ptr<SurfaceTextures::Tile> SurfaceTextures::Bake(const Surface& s, bool back, int level,
                                                             int column, int row) const {
  auto tile = std::make_unique<Tile>();
  const TileLight light(*this, s, back, level, column, row);
  // A texel is the mean over the places about it, weighed as the interpolation between texels weighs it
  // there: so detail that is finer than texels stays where it is, whatever its place between them. The places
  // are random in the cells of a grid, as even ones would show joints where these happen to lie.
  const int samples = level < 5 ? 2 : 3;  // along an edge; distant levels have more to average
  const auto random = [&](int i, int j, int k, std::uint32_t seed) {
    return static_cast<float>(
        Cell(Eigen::Vector2d(samples * samples * (column * kTile + i) + k, row * kTile + j),
             seed + static_cast<std::uint32_t>(level)));
  };
  const Vector3d normal = s.normal.cast<double>();
  for (int j = 0; j < light.rows; ++j) {
    for (int i = 0; i < light.columns; ++i) {
      Vector3f sum = Vector3f::Zero();
      for (int k = 0; k < samples * samples; ++k) {
        // The sum of two even draws, one of them from the cell, falls off as the weights do.
        const float x =
            static_cast<float>(i) - 1.0f + random(i, j, k, 300) +
            (static_cast<float>(k % samples) + random(i, j, k, 400)) / static_cast<float>(samples);
        const float y =
            static_cast<float>(j) - 1.0f + random(i, j, k, 500) +
            (static_cast<float>(k / samples) + random(i, j, k, 600)) / static_cast<float>(samples);
        const Vector3f p = light.Place(x, y);
        const Vector3f albedo = ReflectanceOf(s.material, p.cast<double>(), normal, s.object).albedo;
        sum += albedo.cwiseProduct(light.At(x, y, p));
      }
      Texel& texel = tile->texels[static_cast<std::size_t>(j * kStride + i)];
      for (int c = 0; c < 3; ++c) {
        const float value = sum[c] / (kFullScale * static_cast<float>(samples * samples));
        texel[c] = static_cast<std::uint16_t>(std::clamp(value, 0.0f, 65535.0f));
      }
    }
  }
  for (int j = 0; j < kStride; ++j) {
    for (int i = 0; i < kStride; ++i) {
      if (i < light.columns && j < light.rows) continue;
      tile->texels[static_cast<std::size_t>(j * kStride + i)] = tile->texels[static_cast<std::size_t>(
          std::min(j, light.rows - 1) * kStride + std::min(i, light.columns - 1))];
    }
  }
  return tile;
}

}  // namespace mlic::sim
