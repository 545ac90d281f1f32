// Worlds under the sky: yard, street, slope, grove.
#include <algorithm>
#include <cmath>
#include <functional>

#include "mlic_sim/procedural_noise.h"
#include "mlic_sim/surroundings.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated worlds.

using Eigen::Vector2d;
using Eigen::Vector3d;
using Height = std::function<double(double, double)>;

constexpr double kGroundHalfLength = 46.0, kGroundHalfWidth = 34.0;  // m, of the ground

double HeightOf(const Mesh& mesh, double x, double y) {
  return mesh.ground_height() ? mesh.ground_height()(x, y) : 0.0;
}

void AddGround(const Terrain& terrain, double roughness, bool flat, Material material, Mesh& mesh) {
  if (flat) {
    mesh.AddQuad({-kGroundHalfLength, -kGroundHalfWidth, 0}, {kGroundHalfLength, -kGroundHalfWidth, 0},
                 {kGroundHalfLength, kGroundHalfWidth, 0}, {-kGroundHalfLength, kGroundHalfWidth, 0},
                 material);
    return;
  }
  const Height height = [terrain, roughness](double x, double y) {
    double z = UnevenGroundHeight(x, y) + terrain.Height(x, y);
    if (roughness > 0.0) z += 2.0 * roughness * (Fractal(Vector3d(x, y, 0), 0.4, 3, 301) - 0.5);
    return z;
  };
  mesh.AddHeightField({-kGroundHalfLength, -kGroundHalfWidth}, {kGroundHalfLength, kGroundHalfWidth},
                      roughness > 0.0 ? 0.2 : 0.4, height, material);
}

Terrain Hills(Random& draw, double most) {
  Terrain terrain;
  for (int i = 0; i < 3; ++i) {
    const double length = draw.Uniform(35.0, 70.0), direction = draw.Uniform(0.0, 2.0 * M_PI);
    const double k = 2.0 * M_PI / length;
    terrain.waves.push_back({draw.Uniform(0.4, 1.0) * most, k * std::cos(direction), k * std::sin(direction),
                             draw.Uniform(0.0, 2.0 * M_PI)});
  }
  return terrain;
}

Building RandomBuilding(const Vector2d& low, const Vector2d& high, double tallest, Random& draw) {
  const Material walls[] = {Material::kBrick, Material::kPlaster, Material::kConcrete};
  Building b{low, high, draw.Uniform(3.6, tallest), 0.0, walls[draw.Next() % 3], AnyObject(draw)};
  if (draw.Uniform() < 0.4) b.roof_rise = draw.Uniform(1.2, 3.2) * (draw.Uniform() < 0.5 ? -1.0 : 1.0);
  b.window_depth = draw.Uniform(0.04, 0.35);
  b.bay = draw.Uniform(2.5, 4.6);
  b.storey = draw.Uniform(2.8, 3.8);
  return b;
}

// Buildings side by side along x from -length to length, whose fronts are `distance` from the x axis on the
// given side, set back by up to `setback`.
struct Row {
  double side, distance, length, setback, tallest, most_gap;
};
void AddRow(const Row& row, Random& draw, Mesh& mesh) {
  for (double x = -row.length; x < row.length;) {
    const double end = std::min(row.length, x + draw.Uniform(7.0, 18.0));
    const double front = row.distance + draw.Uniform(0.0, row.setback), back = row.distance + 9.0;
    const Vector2d low(x, row.side > 0 ? front : -back), high(end, row.side > 0 ? back : -front);
    Building b = RandomBuilding(low, high, row.tallest, draw);
    for (const Vector2d& corner : {low, high, Vector2d(low.x(), high.y()), Vector2d(high.x(), low.y())}) {
      b.base = std::min(b.base, HeightOf(mesh, corner.x(), corner.y()));
    }
    if (end - x > 4.0) AddBuilding(b, mesh);
    x = end + draw.Uniform(0.0, row.most_gap);
  }
}

// A building that shuts one end of the x axis.
void AddEnd(double side, double distance, double half_width, Random& draw, Mesh& mesh) {
  const double x = side * distance, far = side * (distance + 8.0);
  Building b = RandomBuilding({std::min(x, far), -half_width}, {std::max(x, far), half_width}, 12.0, draw);
  b.base = std::min(HeightOf(mesh, x, -half_width), HeightOf(mesh, x, half_width));
  AddBuilding(b, mesh);
}

// `count` things at random where rigs do not go; add(x, y, z, draw) puts one there.
template <typename Add>
void Scatter(int count, double radius, Random& draw, const Mesh& mesh, const Add& add) {
  for (int i = 0, tries = 0; i < count && tries < 20 * count; ++tries) {
    const double x = draw.Uniform(-kGroundHalfLength + 6.0, kGroundHalfLength - 6.0);
    const double y = draw.Uniform(-kGroundHalfWidth + 12.0, kGroundHalfWidth - 12.0);
    if (!IsClear(x, y, radius)) continue;
    add(x, y, HeightOf(mesh, x, y), draw);
    ++i;
  }
}

void AddClutter(int count, Random& draw, Mesh& mesh) {
  Scatter(count, 1.6, draw, mesh, [&](double x, double y, double z, Random& at) {
    const double yaw = at.Uniform(-M_PI, M_PI), kind = at.Uniform();
    const std::uint32_t object = AnyObject(at);
    if (kind < 0.35) {
      const Vector3d half(at.Uniform(0.2, 1.3), at.Uniform(0.2, 1.4), at.Uniform(0.2, 1.3));
      mesh.AddBox(Upright(x, y, z + half.z() - 0.1, yaw), half,
                  at.Uniform() < 0.5 ? Material::kCarPaint : Material::kCardboard, object);
    } else if (kind < 0.6) {
      const double rise = at.Uniform(0.4, 1.4);
      mesh.AddPrism(Upright(x, y, z - 0.2, yaw), {{-1.6, -0.2}, {1.6, -0.2}, {1.6, rise}, {0.9, rise}},
                    at.Uniform(0.5, 1.2), at.Uniform() < 0.5 ? Material::kConcrete : Material::kSignBoard,
                    object);
    } else if (kind < 0.8) {
      mesh.AddCylinder(Upright(x, y, z - 0.2, 0), at.Uniform(0.1, 0.7), at.Uniform(0.8, 3.0), 20,
                       at.Uniform() < 0.5 ? Material::kConcrete : Material::kMetal, object);
    } else {
      AddSignPole(x, y, yaw, object, mesh);
    }
  });
}

void AddParkedCars(int count, Random& draw, Mesh& mesh) {
  Scatter(count, 2.6, draw, mesh, [&](double x, double y, double z, Random& at) {
    const bool van = at.Uniform() < 0.25;
    AddCar(x, y, z, at.Uniform(-M_PI, M_PI), van, AnyObject(at), mesh);
  });
}

Lane OnGround(Lane::Kind kind, const Vector2d& from, const Vector2d& to, const Mesh& mesh) {
  return {kind,
          {from.x(), from.y(), HeightOf(mesh, from.x(), from.y())},
          {to.x(), to.y(), HeightOf(mesh, to.x(), to.y())}};
}

void AddLanes(double traffic, double people, Surroundings& world) {
  using Kind = Lane::Kind;
  world.lanes = {OnGround(Kind::kTraffic, {42, traffic}, {-42, traffic}, world.mesh),
                 OnGround(Kind::kPeople, {-15, people}, {15, people + 0.6}, world.mesh),
                 OnGround(Kind::kPeople, {25, -people}, {-9, -people - 0.5}, world.mesh)};
}

}  // namespace

Surroundings MakeRandomYard(const Random& random, bool flat) {
  Surroundings world;
  world.lighting = YardLighting();
  AddGround({}, 0.0, flat, Material::kYardGround, world.mesh);
  Random draw = random.Fork(1);
  const double gap = draw.Uniform(0.0, 7.0);
  for (double side : {-1.0, 1.0}) {
    AddRow({side, draw.Uniform(15.5, 24.0), 44.0, 3.0, 13.0, gap}, draw, world.mesh);
    AddEnd(side, draw.Uniform(34.0, 44.0), draw.Uniform(5.0, 13.0), draw, world.mesh);
  }
  AddParkedCars(static_cast<int>(draw.Next() % 10), draw, world.mesh);
  AddClutter(6 + static_cast<int>(draw.Next() % 14), draw, world.mesh);
  Scatter(static_cast<int>(draw.Next() % 6), 1.2, draw, world.mesh,
          [&](double x, double y, double, Random& at) {
            AddTree(x, y, at.Uniform(4.0, 7.0), at.Fork(0), world.mesh);
          });
  AddLanes(11.9, 13.4, world);
  return world;
}

Surroundings MakeStreet(const Random& random, bool flat) {
  Surroundings world;
  world.lighting = YardLighting();
  Mesh& mesh = world.mesh;
  AddGround({}, 0.0, flat, Material::kAsphalt, mesh);
  Random draw = random.Fork(2);
  const double half_width = draw.Uniform(18.5, 22.0);
  const double crossing = draw.Uniform(-14.0, 14.0), half_crossing = draw.Uniform(4.0, 6.0);
  for (double side : {-1.0, 1.0}) {
    // Two rows with the crossing between them, each of its own.
    const double west = 0.5 * (crossing - half_crossing + kGroundHalfLength);
    for (double part : {-1.0, 1.0}) {
      const double length = part < 0 ? west : 0.5 * (kGroundHalfLength - crossing - half_crossing);
      const double center = part < 0 ? -kGroundHalfLength + length : kGroundHalfLength - length;
      Mesh row;
      AddRow({side, half_width, length, 1.5, 18.0, draw.Uniform() < 0.3 ? 3.0 : 0.0}, draw, row);
      mesh.Append(row, Vector3d(center, 0, 0));
      const Vector3d pavement(center, side * (half_width - 1.4), 0);
      mesh.AddBox(pavement - Vector3d(length, 1.4, 0.3), pavement + Vector3d(length, 2.9, 0.12),
                  Material::kKerb);
    }
    for (double x = -kGroundHalfLength + draw.Uniform(4.0, 12.0); x < kGroundHalfLength;
         x += draw.Uniform(12.0, 22.0)) {
      if (std::abs(x - crossing) < half_crossing) continue;
      const double y = side * (half_width - 2.2);
      if (draw.Uniform() < 0.3) {
        AddTree(x, y, draw.Uniform(4.5, 7.0), draw.Fork(7), mesh);
      } else {
        AddSignPole(x, y, -side * 0.5 * M_PI + draw.Uniform(-0.3, 0.3), AnyObject(draw), mesh);
      }
    }
    const double taken = draw.Uniform(0.2, 0.9);
    for (double x = -40.0; x < 40.0; x += draw.Uniform(5.8, 7.0)) {
      if (draw.Uniform() > taken || std::abs(x - crossing) < half_crossing + 3.0) continue;
      const double y = side * (half_width - 4.1 + draw.Uniform(-0.15, 0.15));
      AddCar(x, y, flat ? 0.0 : UnevenGroundHeight(x, y),
             (draw.Uniform() < 0.5 ? 0.0 : M_PI) + draw.Uniform(-0.04, 0.04), draw.Uniform() < 0.25,
             AnyObject(draw), mesh);
    }
    if (draw.Uniform() < 0.5) AddEnd(side, 40.0, half_width - 3.0, draw, mesh);
  }
  AddLanes(11.9, half_width - 1.2, world);
  return world;
}

Surroundings MakeSlope(const Random& random) {
  Surroundings world;
  world.lighting = YardLighting();
  Random draw = random.Fork(3);
  world.ground.terrain = Hills(draw, 0.8);
  AddGround(world.ground.terrain, 0.0, false, draw.Uniform() < 0.5 ? Material::kAsphalt : Material::kGrass,
            world.mesh);
  for (double side : {-1.0, 1.0}) {
    AddRow({side, draw.Uniform(16.0, 24.0), 44.0, 4.0, 10.0, 9.0}, draw, world.mesh);
    AddEnd(side, draw.Uniform(34.0, 44.0), draw.Uniform(4.0, 10.0), draw, world.mesh);
  }
  // Walls that hold the slope.
  Scatter(4, 3.2, draw, world.mesh, [&](double x, double y, double z, Random& at) {
    world.mesh.AddBox(Upright(x, y, z, at.Uniform(-M_PI, M_PI)), Vector3d(3.0, 0.15, at.Uniform(0.6, 1.4)),
                      at.Uniform() < 0.5 ? Material::kBrick : Material::kConcrete, AnyObject(at));
  });
  AddParkedCars(3 + static_cast<int>(draw.Next() % 5), draw, world.mesh);
  AddClutter(8 + static_cast<int>(draw.Next() % 10), draw, world.mesh);
  AddLanes(12.2, 14.0, world);
  return world;
}

Surroundings MakeGrove(const Random& random) {
  Surroundings world;
  world.lighting = YardLighting();
  Mesh& mesh = world.mesh;
  Random draw = random.Fork(4);
  world.ground.terrain = Hills(draw, 0.25);
  AddGround(world.ground.terrain, draw.Uniform(0.02, 0.06), false, Material::kGrass, mesh);
  const double leaves = draw.Uniform(100.0, 400.0);
  Scatter(
      40 + static_cast<int>(draw.Next() % 60), 0.6, draw, mesh,
      [&](double x, double y, double z, Random& at) {
        const double height = at.Uniform(5.0, 11.0), radius = at.Uniform(0.08, 0.32);
        Eigen::Isometry3d trunk = Upright(x, y, z - 0.3, at.Uniform(-M_PI, M_PI));
        trunk.rotate(Eigen::AngleAxisd(at.Uniform(0.0, 0.1), Vector3d::UnitY()));
        mesh.AddCylinder(trunk, radius, 0.7 * height, 14, Material::kBark, AnyObject(at));
        AddCrown({trunk * Vector3d(0, 0, 0.75 * height), 0.25 * height, static_cast<int>(leaves)}, at, mesh);
      });
  Scatter(20, 1.2, draw, mesh, [&](double x, double y, double z, Random& at) {
    AddCrown({{x, y, z + 0.5}, at.Uniform(0.4, 1.1), static_cast<int>(0.6 * leaves)}, at, mesh);
  });
  Scatter(8, 0.8, draw, mesh, [&](double x, double y, double z, Random& at) {
    Eigen::Isometry3d rock = Upright(x, y, z, at.Uniform(-M_PI, M_PI));
    rock.rotate(Eigen::AngleAxisd(at.Uniform(-0.5, 0.5), Vector3d::UnitX()));
    mesh.AddBox(rock, Vector3d(at.Uniform(0.2, 0.7), at.Uniform(0.2, 0.7), at.Uniform(0.2, 0.6)),
                Material::kConcrete, AnyObject(at));
  });
  AddLanes(12.2, 14.0, world);
  world.lanes.erase(std::remove_if(world.lanes.begin(), world.lanes.end(),
                                   [](const Lane& lane) { return lane.kind == Lane::Kind::kTraffic; }),
                    world.lanes.end());
  return world;
}

}  // namespace mlic::sim
