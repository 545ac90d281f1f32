#include "mlic_sim/furniture.h"

#include <algorithm>
#include <cmath>

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated world.

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// One wall: `origin` is its lower left corner as seen from outside, u runs along it, n points outward.
struct Facade {
  Vector3d origin, u, n;
  double width, height;
  double window_depth, bay, storey;

  Vector3d At(double along, double up, double out) const {
    return origin + along * u + up * Vector3d::UnitZ() + out * n;
  }
};

// Part of a facade, along it and upwards.
struct Area {
  double a0, a1, z0, z1;
};

void AddRectangle(const Facade& f, const Area& area, double out, Material material, std::uint32_t object,
                  Mesh& mesh) {
  const auto& [a0, a1, z0, z1] = area;
  if (a1 - a0 < 1e-6 || z1 - z0 < 1e-6) return;
  mesh.AddQuad(f.At(a0, z0, out), f.At(a1, z0, out), f.At(a1, z1, out), f.At(a0, z1, out), material, object);
}

// An opening, filled with `filling` at `depth` behind the wall, with its four reveals.
void AddOpening(const Facade& f, const Area& area, double depth, Material filling, std::uint32_t object,
                Mesh& mesh) {
  const double a0 = area.a0, a1 = area.a1, z0 = area.z0, z1 = area.z1;
  AddRectangle(f, area, -depth, filling, object, mesh);
  const auto reveal = [&](double b0, double y0, double b1, double y1) {
    mesh.AddQuad(f.At(b0, y0, 0), f.At(b1, y1, 0), f.At(b1, y1, -depth), f.At(b0, y0, -depth),
                 Material::kWindowFrame, object);
  };
  reveal(a0, z0, a1, z0);
  reveal(a0, z1, a1, z1);
  reveal(a0, z0, a0, z1);
  reveal(a1, z0, a1, z1);
}

void AddFacade(const Facade& f, Material wall, std::uint32_t object, Mesh& mesh) {
  constexpr double kBelow = 0.4;  // walls go on below the ground
  const int bays = std::max(1, static_cast<int>(f.width / f.bay));
  const int storeys = std::max(1, static_cast<int>(f.height / f.storey));
  const double bay = f.width / bays;
  for (int i = 0; i < bays; ++i) {
    const double left = i * bay, right = left + bay, a0 = left + 0.3 * bay, a1 = left + 0.72 * bay;
    for (int j = 0; j < storeys; ++j) {
      const bool door = j == 0 && i == bays / 2;
      const double low = j == 0 ? -kBelow : j * f.storey;
      const double high = j + 1 == storeys ? f.height : (j + 1) * f.storey;
      const double z0 = door ? 0.1 : j * f.storey + 0.95, z1 = j * f.storey + (door ? 2.2 : 2.45);
      AddRectangle(f, {left, a0, low, high}, 0, wall, object, mesh);
      AddRectangle(f, {a1, right, low, high}, 0, wall, object, mesh);
      AddRectangle(f, {a0, a1, low, z0}, 0, wall, object, mesh);
      AddRectangle(f, {a0, a1, z1, high}, 0, wall, object, mesh);
      AddOpening(f, {a0, a1, z0, z1}, door ? 0.3 : f.window_depth, door ? Material::kDoor : Material::kGlass,
                 object, mesh);
    }
    // A pilaster between the bays.
    if (i > 0) {
      const double a = left - 0.15, b = left + 0.15;
      AddRectangle(f, {a, b, -kBelow, f.height}, 0.18, Material::kConcrete, object, mesh);
      for (double side : {a, b}) {
        mesh.AddQuad(f.At(side, -kBelow, 0), f.At(side, -kBelow, 0.18), f.At(side, f.height, 0.18),
                     f.At(side, f.height, 0), Material::kConcrete, object);
      }
    }
  }
}

}  // namespace

void AddBuilding(const Building& b, Mesh& mesh) {
  const double width = b.high.x() - b.low.x(), depth = b.high.y() - b.low.y(), h = b.height;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY();
  const Vector3d sw(b.low.x(), b.low.y(), b.base), se(b.high.x(), b.low.y(), b.base),
      ne(b.high.x(), b.high.y(), b.base), nw(b.low.x(), b.high.y(), b.base);
  AddFacade({sw, x, -y, width, h, b.window_depth, b.bay, b.storey}, b.wall, b.object, mesh);
  AddFacade({se, y, x, depth, h, b.window_depth, b.bay, b.storey}, b.wall, b.object, mesh);
  AddFacade({ne, -x, y, width, h, b.window_depth, b.bay, b.storey}, b.wall, b.object, mesh);
  AddFacade({nw, -y, -x, depth, h, b.window_depth, b.bay, b.storey}, b.wall, b.object, mesh);
  if (b.roof_rise == 0.0) {
    mesh.AddBox(Vector3d(b.low.x() - 0.25, b.low.y() - 0.25, b.base + h),
                Vector3d(b.high.x() + 0.25, b.high.y() + 0.25, b.base + h + 0.5), Material::kConcrete,
                b.object);
    return;
  }
  // A shed roof with eaves, and the wall below its high side.
  const Vector3d up = Vector3d::UnitZ();
  const double slope = b.roof_rise / depth, eave = 0.7;
  const double low_edge = std::min(0.0, b.roof_rise);
  const auto roof = [&](double px, double py) {
    return Vector3d(px, py, b.base + h - low_edge + slope * (py - b.low.y()));
  };
  mesh.AddQuad(roof(b.low.x() - 0.3, b.low.y() - eave), roof(b.high.x() + 0.3, b.low.y() - eave),
               roof(b.high.x() + 0.3, b.high.y() + eave), roof(b.low.x() - 0.3, b.high.y() + eave),
               Material::kRoofTiles, b.object);
  const double south = -low_edge, north = b.roof_rise - low_edge;
  mesh.AddQuad(sw + h * up, se + h * up, se + (h + south) * up, sw + (h + south) * up, b.wall, b.object);
  mesh.AddQuad(nw + h * up, ne + h * up, ne + (h + north) * up, nw + (h + north) * up, b.wall, b.object);
  mesh.AddQuad(sw + h * up, nw + h * up, nw + (h + north) * up, sw + (h + south) * up, b.wall, b.object);
  mesh.AddQuad(se + h * up, ne + h * up, ne + (h + north) * up, se + (h + south) * up, b.wall, b.object);
}

void AddCar(double x, double y, double z, double yaw, bool van, std::uint32_t object, Mesh& mesh) {
  const Isometry3d T = Upright(x, y, z, yaw);
  if (van) {
    mesh.AddPrism(T, {{-2.6, 0.35}, {2.6, 0.35}, {2.6, 1.05}, {1.9, 1.25}, {1.45, 2.15}, {-2.6, 2.2}}, 0.98,
                  Material::kCarPaint, object);
  } else {
    mesh.AddPrism(
        T, {{-2.2, 0.28}, {2.2, 0.28}, {2.25, 0.62}, {2.1, 0.78}, {1.0, 0.92}, {-1.75, 0.95}, {-2.2, 0.85}},
        0.88, Material::kCarPaint, object);
    mesh.AddPrism(T, {{1.0, 0.92}, {0.25, 1.42}, {-1.15, 1.45}, {-1.75, 0.95}}, 0.76, Material::kGlass,
                  object);
    mesh.AddPrism(T, {{0.25, 1.42}, {0.1, 1.46}, {-1.05, 1.49}, {-1.15, 1.45}}, 0.72, Material::kCarPaint,
                  object);
  }
  for (double wheel_x : {-1.4, 1.4}) {
    for (double side : {-1.0, 1.0}) {
      Isometry3d wheel = T;
      wheel.translate(Vector3d(wheel_x, side * (van ? 1.0 : 0.9) - 0.11, 0.32));
      wheel.rotate(Eigen::AngleAxisd(-0.5 * M_PI, Vector3d::UnitX()));
      mesh.AddCylinder(wheel, 0.32, 0.22, 16, Material::kRubber, object);
    }
  }
}

void AddCrown(const Crown& crown, Random& random, Mesh& mesh) {
  for (int i = 0; i < crown.count; ++i) {
    const Vector3d direction(random.Normal(), random.Normal(), random.Normal());
    const Vector3d center = crown.center + crown.radius * std::cbrt(random.Uniform()) *
                                               direction.normalized().cwiseProduct(Vector3d(1, 1, 0.9));
    Isometry3d T = Isometry3d::Identity();
    T.translate(center).rotate(
        Eigen::Quaterniond(random.Normal(), random.Normal(), random.Normal(), random.Normal()).normalized());
    const double s = random.Uniform(0.05, 0.13);
    mesh.AddQuad(T * Vector3d(-s, -s, 0), T * Vector3d(s, -s, 0), T * Vector3d(s, s, 0),
                 T * Vector3d(-s, s, 0), Material::kFoliage);
  }
}

void AddTree(double x, double y, double height, Random random, Mesh& mesh) {
  mesh.AddCylinder(Upright(x, y, -0.2, 0), 0.16, 0.6 * height, 14, Material::kBark);
  AddCrown({Vector3d(x, y, 0.7 * height), 0.28 * height, 700}, random, mesh);
}

void AddSignPole(double x, double y, double yaw, std::uint32_t object, Mesh& mesh) {
  mesh.AddCylinder(Upright(x, y, -0.2, 0), 0.07, 5.2, 18, Material::kMetal, object);
  const Isometry3d T = Upright(x, y, 0, yaw);
  Isometry3d board = T;
  board.translate(Vector3d(0.1, 0, 2.3));
  mesh.AddBox(board, Vector3d(0.015, 0.45, 0.35), Material::kSignBoard, object);
  Isometry3d lamp = T;
  lamp.translate(Vector3d(0.4, 0, 5.0));
  mesh.AddBox(lamp, Vector3d(0.45, 0.1, 0.06), Material::kMetal, object);
}

void AddTable(double x, double y, double yaw, Mesh& mesh) {
  Isometry3d top = Upright(x, y, 0.73, yaw);
  mesh.AddBox(top, Vector3d(0.8, 0.4, 0.02), Material::kWood);
  for (double u : {-0.74, 0.74}) {
    for (double v : {-0.34, 0.34}) {
      Isometry3d leg = Upright(x, y, 0.355, yaw);
      leg.translate(Vector3d(u, v, 0));
      mesh.AddBox(leg, Vector3d(0.03, 0.03, 0.355), Material::kMetal);
    }
  }
}

void AddShelf(double x, double y, double yaw, Random random, Mesh& mesh) {
  const Isometry3d T = Upright(x, y, 0, yaw);
  const auto box = [&](const Vector3d& center, const Vector3d& half, Material material,
                       std::uint32_t object) {
    Isometry3d at = T;
    at.translate(center);
    mesh.AddBox(at, half, material, object);
  };
  for (double side : {-1.35, 1.35}) {
    for (double depth : {-0.28, 0.28}) box({depth, side, 1.3}, {0.03, 0.03, 1.3}, Material::kMetal, 0);
  }
  for (double level : {0.15, 0.95, 1.75, 2.5}) {
    box({0, 0, level}, {0.32, 1.4, 0.02}, Material::kWood, 0);
    for (int i = 0; i < 4; ++i) {
      if (random.Uniform() < 0.25) continue;
      const Vector3d half(random.Uniform(0.14, 0.26), random.Uniform(0.15, 0.3), random.Uniform(0.1, 0.3));
      box({random.Uniform(-0.05, 0.1), -1.0 + 0.66 * i, level + 0.02 + half.z()}, half, Material::kCardboard,
          static_cast<std::uint32_t>(random.Next() % 1000));
    }
  }
}

void AddLeaningBoard(const LeaningBoard& board, Material material, std::uint32_t object, Mesh& mesh) {
  Isometry3d T = Upright(board.x, board.y, 0, board.yaw);
  T.rotate(Eigen::AngleAxisd(-board.tilt, Vector3d::UnitY())).translate(Vector3d(0, 0, 0.5 * board.height));
  mesh.AddBox(T, Vector3d(0.02, 0.5 * board.width, 0.5 * board.height), material, object);
}

}  // namespace mlic::sim
