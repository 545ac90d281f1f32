#include "mlic_sim/material.h"

#include <algorithm>
#include <cmath>

#include "mlic_sim/procedural_noise.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated world.

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

Vector3f Rgb(double r, double g, double b) {
  return Vector3f(static_cast<float>(r), static_cast<float>(g), static_cast<float>(b));
}

Vector3f Mix(const Vector3f& a, const Vector3f& b, double share) {
  return a + static_cast<float>(share) * (b - a);
}

Reflectance Make(const Vector3f& albedo, double near_infrared) {
  Reflectance r;
  r.albedo = albedo.cwiseMax(0.01f).cwiseMin(0.97f);
  r.near_infrared = static_cast<float>(std::clamp(near_infrared, 0.02, 0.97));
  return r;
}

// Coordinates along a surface, m: for walls horizontal and up, for floors and roofs x and y.
Vector2d SurfaceCoordinates(const Vector3d& p, const Vector3d& normal) {
  if (std::abs(normal.z()) > 0.7) return {p.x(), p.y()};
  Vector2d across(-normal.y(), normal.x());
  // Both faces of one wall run the same way.
  if (across.x() + 0.01 * across.y() < 0.0) across = -across;
  across.normalize();
  return {across.x() * p.x() + across.y() * p.y(), p.z()};
}

// 1 inside |x| < half_width, 0 outside, without a soft edge: paint is sharp.
bool Within(double x, double half_width) { return std::abs(x) < half_width; }

// Distance to the nearest multiple of period.
double ToMultiple(double x, double period) { return x - period * std::round(x / period); }

bool IsMarked(const Vector2d& p) {
  const double x = p.x(), y = p.y();
  // Parking stripes along the long sides, a lane line with dashes, two zebra crossings, stop lines.
  if (std::abs(y) > 13.0 && std::abs(y) < 18.0 && Within(ToMultiple(x, 2.6), 0.06)) return true;
  if (Within(std::abs(y) - 13.0, 0.06) && std::abs(x) < 30.0) return true;
  if (Within(y + 9.9, 0.07) && ToMultiple(x, 3.0) > -0.5) return true;
  if (Within(std::abs(x) - 5.0, 1.5) && std::abs(y) < 9.0 && Within(ToMultiple(y, 1.0), 0.25)) return true;
  if (Within(std::abs(x) - 27.0, 0.15) && std::abs(y) < 10.0) return true;
  // Arrows: a shaft and a triangular head.
  const double ax = ToMultiple(x, 16.0), ay = y - 10.6;
  if (Within(ay, 0.08) && ax > -1.5 && ax < 0.5) return true;
  return ax >= 0.5 && ax < 1.5 && std::abs(ay) < 0.35 * (1.5 - ax);
}

Reflectance Asphalt(const Vector3d& p, bool marked) {
  const double grain = Fractal(p, 0.025, 2, 11), blotch = Fractal(p, 1.3, 4, 12);
  const bool repaired = Cell(Vector2d(p.x() / 3.7, p.y() / 2.9), 13) > 0.85;
  double gray = 0.17 + 0.09 * (grain - 0.5) + 0.12 * (blotch - 0.5) - (repaired ? 0.06 : 0.0);
  double infrared = 0.22 + 0.10 * (grain - 0.5) + 0.10 * (blotch - 0.5) + (repaired ? -0.08 : 0.0);
  // Cracks: where a coarse noise passes through one half.
  if (std::abs(Fractal(p, 2.1, 3, 14) - 0.5) < 0.004) gray *= 0.45, infrared *= 0.6;
  // Manhole covers on a grid.
  const double mx = ToMultiple(p.x() - 3.3, 11.0), my = ToMultiple(p.y() - 1.7, 9.0),
               radius = std::hypot(mx, my);
  if (radius < 0.33) {
    const bool rib = std::sin(60.0 * mx) * std::sin(60.0 * my) > 0.0;
    return Make(Rgb(0.2, 0.19, 0.18) * (rib ? 1.3f : 0.7f), rib ? 0.4 : 0.25);
  }
  if (marked && IsMarked(Vector2d(p.x(), p.y()))) {
    const double worn = Fractal(p, 0.12, 4, 15);
    if (worn > 0.36)
      return Make(Rgb(0.85, 0.85, 0.80) * static_cast<float>(0.8 + 0.3 * worn), 0.75 + 0.2 * worn);
  }
  return Make(Rgb(gray, gray, gray * 1.04), infrared);
}

Reflectance Grass(const Vector3d& p) {
  const double blade = Fractal(p, 0.012, 3, 131), tuft = Fractal(p, 0.35, 4, 132),
               bare = Fractal(p, 2.4, 4, 133);
  const double tone = 0.6 + 0.5 * blade + 0.5 * (tuft - 0.5);
  if (bare > 0.6) return Make(Rgb(0.36, 0.28, 0.19) * static_cast<float>(tone), 0.38 * tone);
  return Make(Mix(Rgb(0.16, 0.27, 0.08), Rgb(0.38, 0.38, 0.16), tuft) * static_cast<float>(tone),
              0.55 * tone);
}

Reflectance Brick(const Vector3d& p, const Vector3d& normal, std::uint32_t object) {
  constexpr double kLength = 0.25, kHeight = 0.077, kJoint = 0.006;
  const Vector2d uv = SurfaceCoordinates(p, normal);
  const double row = std::floor(uv.y() / kHeight);
  const double u = uv.x() / kLength + (std::fmod(std::abs(row), 2.0) > 0.5 ? 0.5 : 0.0);
  const double grain = Fractal(p, 0.02, 2, 21), stain = Fractal(p, 1.7, 4, 22);
  const bool joint =
      Within(ToMultiple(u * kLength, kLength), kJoint) || Within(ToMultiple(uv.y(), kHeight), kJoint);
  if (joint) return Make(Rgb(0.62, 0.60, 0.55) * static_cast<float>(0.7 + 0.5 * stain), 0.55 + 0.15 * stain);
  const double brick = Cell(Vector2d(u, row + 0.5), 23 + object);
  const Vector3f dark = object % 2 == 0 ? Rgb(0.36, 0.13, 0.09) : Rgb(0.42, 0.33, 0.20);
  const Vector3f light = object % 2 == 0 ? Rgb(0.62, 0.27, 0.18) : Rgb(0.72, 0.60, 0.42);
  const double tone = 0.75 + 0.35 * stain + 0.2 * (grain - 0.5);
  return Make(Mix(dark, light, brick) * static_cast<float>(tone), (0.36 + 0.24 * brick) * tone);
}

Reflectance Plaster(const Vector3d& p, std::uint32_t object) {
  const double grain = Fractal(p, 0.03, 3, 31),
               stain = Fractal(p.cwiseProduct(Vector3d(1, 1, 0.4)), 1.1, 4, 32);
  static const Vector3f colors[] = {Rgb(0.80, 0.76, 0.62), Rgb(0.74, 0.79, 0.80), Rgb(0.83, 0.66, 0.52)};
  const double tone = 0.62 + 0.5 * stain + 0.25 * (grain - 0.5);
  return Make(colors[object % 3] * static_cast<float>(tone), (0.52 + 0.06 * (object % 3)) * tone);
}

Reflectance Concrete(const Vector3d& p, const Vector3d& normal) {
  const Vector2d uv = SurfaceCoordinates(p, normal);
  const double grain = Fractal(p, 0.03, 3, 41), stain = Fractal(p, 0.9, 4, 42);
  const bool joint = Within(ToMultiple(uv.x(), 1.2), 0.008) || Within(ToMultiple(uv.y(), 1.2), 0.008);
  const double gray = (0.30 + 0.35 * stain + 0.15 * (grain - 0.5)) * (joint ? 0.5 : 1.0);
  return Make(Rgb(gray, gray * 0.99, gray * 0.95), 0.9 * gray + 0.12);
}

Reflectance RoofTiles(const Vector3d& p) {
  const double tile = Cell(Vector2d(p.x() / 0.25, p.y() / 0.3), 51), moss = Fractal(p, 0.8, 4, 52);
  const Vector3f color =
      Mix(Rgb(0.45, 0.16, 0.10), Rgb(0.28, 0.30, 0.16), std::clamp(3.0 * moss - 1.4, 0.0, 1.0));
  return Make(color * static_cast<float>(0.7 + 0.5 * tile), 0.30 + 0.25 * tile + 0.2 * (moss - 0.5));
}

Reflectance CarPaint(const Vector3d& p, std::uint32_t object) {
  static const Vector3f colors[] = {Rgb(0.62, 0.06, 0.05), Rgb(0.08, 0.14, 0.42), Rgb(0.82, 0.82, 0.80),
                                    Rgb(0.07, 0.07, 0.08), Rgb(0.50, 0.52, 0.53), Rgb(0.10, 0.30, 0.14)};
  static const double infrared[] = {0.55, 0.32, 0.78, 0.08, 0.48, 0.36};
  const double dirt = Fractal(p, 0.3, 4, 61 + object);
  // Gaps of doors and panels.
  const double gap = Within(ToMultiple(p.x() + p.y() + 0.4 * object, 1.1), 0.006) ? 0.4 : 1.0;
  const float tone = static_cast<float>((0.75 + 0.4 * dirt) * gap);
  return Make(colors[object % 6] * tone + Rgb(0.06, 0.05, 0.04) * static_cast<float>(dirt),
              infrared[object % 6] * tone);
}

Reflectance HallFloor(const Vector3d& p) {
  const Vector2d tile(p.x() / 0.6, p.y() / 0.6);
  const double tone = Cell(tile, 71), grain = Fractal(p, 0.02, 2, 72), dirt = Fractal(p, 0.7, 4, 73);
  if (Within(ToMultiple(p.x(), 0.6), 0.004) || Within(ToMultiple(p.y(), 0.6), 0.004)) {
    return Make(Rgb(0.12, 0.12, 0.12), 0.2);
  }
  // A yellow safety line about the walking area.
  if (Within(std::abs(p.x()) - 8.2, 0.05) || Within(std::abs(p.y()) - 4.6, 0.05)) {
    return Make(Rgb(0.85, 0.68, 0.10), 0.7);
  }
  const double gray = 0.32 + 0.22 * tone + 0.25 * (dirt - 0.5) + 0.1 * (grain - 0.5);
  return Make(Rgb(gray, gray * 0.97, gray * 0.9), 0.75 * gray + 0.1 + 0.1 * Cell(tile, 74));
}

Reflectance HallWall(const Vector3d& p, const Vector3d& normal) {
  const Vector2d uv = SurfaceCoordinates(p, normal);
  // Posters of 1.1 x 1.6 m with blocks and stripes of print, every 2.3 m.
  const double pu = ToMultiple(uv.x(), 2.3), pv = uv.y() - 1.9;
  const double poster = std::round(uv.x() / 2.3);
  if (std::abs(normal.z()) < 0.5 && std::abs(pu) < 0.55 && std::abs(pv) < 0.8) {
    const double block = Cell(Vector2d(pu / 0.18 + 100.0 * poster, pv / 0.11), 81);
    const double line = std::sin(2.0 * M_PI * pv / 0.045) > 0.2 && block > 0.4 ? 0.35 : 1.0;
    const double hue = Cell(Vector2d(poster + 0.5, 0.5), 82);
    const Vector3f color = Mix(Rgb(0.85, 0.25 + 0.5 * hue, 0.15), Rgb(0.1, 0.25, 0.3 + 0.6 * hue), block);
    return Make(color * static_cast<float>(line), (0.25 + 0.6 * block) * (0.5 + 0.5 * line));
  }
  const double grain = Fractal(p, 0.03, 3, 83), stain = Fractal(p, 1.2, 4, 84);
  const double tone = 0.7 + 0.4 * stain + 0.15 * (grain - 0.5);
  const Vector3f paint = uv.y() < 1.0 ? Rgb(0.32, 0.45, 0.42) : Rgb(0.82, 0.80, 0.74);
  return Make(paint * static_cast<float>(tone), (uv.y() < 1.0 ? 0.42 : 0.68) * tone);
}

Reflectance Wood(const Vector3d& p) {
  const double ring = Fractal(p.cwiseProduct(Vector3d(1.0, 6.0, 6.0)), 0.25, 4, 91);
  const double grain = 0.5 + 0.5 * std::sin(40.0 * ring);
  return Make(Mix(Rgb(0.36, 0.21, 0.10), Rgb(0.68, 0.48, 0.28), grain), 0.45 + 0.25 * grain);
}

Reflectance Cardboard(const Vector3d& p, const Vector3d& normal, std::uint32_t object) {
  const Vector2d uv = SurfaceCoordinates(p, normal);
  const double grain = Fractal(p, 0.04, 3, 101), tone = 0.8 + 0.3 * Fractal(p, 0.4, 3, 102 + object);
  // Packing tape and printed labels.
  if (Within(ToMultiple(uv.x() + 0.13 * object, 0.7), 0.03)) return Make(Rgb(0.75, 0.66, 0.45), 0.75);
  if (Cell(Vector2d(uv.x() / 0.15, uv.y() / 0.10), 103 + object) > 0.86) {
    const bool ink = std::sin(uv.x() / 0.006 + object) > 0.0;
    return Make(ink ? Rgb(0.05, 0.05, 0.06) : Rgb(0.9, 0.9, 0.88), ink ? 0.12 : 0.85);
  }
  return Make(Rgb(0.60, 0.44, 0.27) * static_cast<float>(tone + 0.2 * (grain - 0.5)), 0.55 * tone);
}

Reflectance SignBoard(const Vector3d& p, const Vector3d& normal, std::uint32_t object) {
  const Vector2d uv = SurfaceCoordinates(p, normal);
  const double block = Cell(Vector2d(uv.x() / 0.16, uv.y() / 0.12), 111 + object);
  if (block > 0.6) return Make(Rgb(0.95, 0.94, 0.9), 0.92);
  return Make(object % 2 == 0 ? Rgb(0.05, 0.15, 0.5) : Rgb(0.7, 0.08, 0.06), object % 2 == 0 ? 0.3 : 0.6);
}

Reflectance Speckled(const Vector3d& p, const Vector3f& color, double near_infrared, double contrast,
                     int seed) {
  const double tone = 1.0 + contrast * (Fractal(p, 0.15, 4, seed) - 0.5);
  return Make(color * static_cast<float>(tone), near_infrared * (0.5 + 0.5 * tone));
}

}  // namespace

Reflectance ReflectanceOf(Material material, const Vector3d& p, const Vector3d& normal,
                          std::uint32_t object) {
  switch (material) {
    case Material::kYardGround:
      return Asphalt(p, true);
    case Material::kKerb:
      return Speckled(p, Rgb(0.55, 0.54, 0.51), 0.5, 0.8, 121);
    case Material::kBrick:
      return Brick(p, normal, object);
    case Material::kPlaster:
      return Plaster(p, object);
    case Material::kConcrete:
      return Concrete(p, normal);
    case Material::kGlass:
      return Speckled(p, Rgb(0.10, 0.13, 0.16), 0.09, 0.9, 122);
    case Material::kWindowFrame:
      return Speckled(p, Rgb(0.85, 0.85, 0.83), 0.75, 0.2, 123);
    case Material::kDoor:
      return Speckled(p, Rgb(0.25, 0.18, 0.12), 0.35, 0.7, 124);
    case Material::kRoofTiles:
      return RoofTiles(p);
    case Material::kMetal:
      return Speckled(p, Rgb(0.45, 0.46, 0.47), 0.55, 0.7, 125);
    case Material::kCarPaint:
      return CarPaint(p, object);
    case Material::kRubber:
      return Speckled(p, Rgb(0.05, 0.05, 0.05), 0.06, 0.5, 126);
    case Material::kBark:
      return Speckled(p, Rgb(0.27, 0.20, 0.14), 0.40, 1.2, 127);
    case Material::kFoliage:
      return Speckled(p, Rgb(0.12, 0.25, 0.07), 0.60, 0.9, 128);
    case Material::kHallFloor:
      return HallFloor(p);
    case Material::kHallWall:
      return HallWall(p, normal);
    case Material::kWood:
      return Wood(p);
    case Material::kCardboard:
      return Cardboard(p, normal, object);
    case Material::kSignBoard:
      return SignBoard(p, normal, object);
    case Material::kAsphalt:
      return Asphalt(p, false);
    case Material::kGrass:
      return Grass(p);
  }
  return {};
}

float NearInfraredOf(Material material, const Vector3d& p, const Vector3d& normal, std::uint32_t object,
                     InfraredLook look) {
  const float related = ReflectanceOf(material, p, normal, object).near_infrared;
  const bool inverted =
      look == InfraredLook::kInvertedHalf && (static_cast<std::uint32_t>(material) + object) % 2 == 1;
  return inverted ? std::clamp(1.0f - related, 0.02f, 0.97f) : related;
}

}  // namespace mlic::sim
