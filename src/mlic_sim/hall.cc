#include "mlic_sim/hall.h"

#include <cmath>

#include "mlic_sim/furniture.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated world.

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kHalfLength = 12.0, kHalfWidth = 8.0, kHeight = 6.0;

void AddRoom(Mesh& mesh) {
  const double x = kHalfLength, y = kHalfWidth, z = kHeight;
  mesh.AddQuad({-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}, Material::kHallFloor);
  mesh.AddQuad({-x, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}, Material::kConcrete);
  mesh.AddQuad({-x, -y, 0}, {x, -y, 0}, {x, -y, z}, {-x, -y, z}, Material::kHallWall);
  mesh.AddQuad({-x, y, 0}, {x, y, 0}, {x, y, z}, {-x, y, z}, Material::kBrick, 1);
  mesh.AddQuad({-x, -y, 0}, {-x, y, 0}, {-x, y, z}, {-x, -y, z}, Material::kHallWall);
  mesh.AddQuad({x, -y, 0}, {x, y, 0}, {x, y, z}, {x, -y, z}, Material::kHallWall);
  // Beams under the ceiling, a duct, and pillars that carry them.
  for (double beam : {-8.5, -3.0, 3.0, 8.5}) {
    mesh.AddBox(Vector3d(beam - 0.15, -y, z - 0.55), Vector3d(beam + 0.15, y, z), Material::kConcrete);
    for (double side : {-1.0, 1.0}) {
      mesh.AddBox(Vector3d(beam - 0.25, side * 6.2 - 0.25, 0), Vector3d(beam + 0.25, side * 6.2 + 0.25, z),
                  Material::kConcrete);
    }
  }
  Isometry3d duct = Isometry3d::Identity();
  duct.translate(Vector3d(-x, 2.2, 4.9)).rotate(Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitY()));
  mesh.AddCylinder(duct, 0.32, 2.0 * x, 24, Material::kMetal);
}

void AddEdges(const Random& random, Mesh& mesh) {
  // Shelves along the walls, doors, and boards that lean at different angles.
  int index = 0;
  for (double x : {-6.0, 0.2, 6.0}) AddShelf(x, -7.4, 0.5 * M_PI, random.Fork(++index), mesh);
  for (double y : {-3.4, 1.1}) AddShelf(-11.4, y, 0.0, random.Fork(++index), mesh);
  AddShelf(11.35, 3.4, M_PI, random.Fork(++index), mesh);
  mesh.AddBox(Vector3d(11.85, -2.2, 0), Vector3d(12.0, -0.2, 2.4), Material::kDoor);
  mesh.AddBox(Vector3d(-2.0, 7.9, 0), Vector3d(0.4, 8.0, 2.5), Material::kDoor);
  AddLeaningBoard({-5.6, 7.0, -0.5 * M_PI, 0.35, 2.4, 2.6}, Material::kWood, 0, mesh);
  AddLeaningBoard({5.4, 6.9, -0.5 * M_PI + 0.25, 0.5, 2.2, 2.4}, Material::kSignBoard, 3, mesh);
  AddLeaningBoard({11.0, -5.2, M_PI - 0.3, 0.42, 2.0, 2.8}, Material::kSignBoard, 4, mesh);
  AddLeaningBoard({-10.9, 5.3, -0.4, 0.6, 2.2, 2.2}, Material::kWood, 0, mesh);
  AddLeaningBoard({2.8, -5.3, 0.5 * M_PI + 0.5, 0.3, 1.4, 2.0}, Material::kSignBoard, 5, mesh);
  // A ramp to a platform and stacks of crates.
  mesh.AddPrism(Upright(9.6, 6.6, 0, M_PI), {{-2.2, 0.0}, {2.6, 0.0}, {-0.6, 1.2}, {-2.2, 1.2}}, 1.1,
                Material::kConcrete);
  Random draw = random.Fork(100);
  const double stacks[][2] = {{-9.6, -6.0}, {9.4, -6.4}, {-9.0, 6.6}, {1.9, 6.9}, {-3.2, -5.4}, {10.4, 0.9}};
  for (const auto& stack : stacks) {
    double z = 0.0;
    for (int level = 0; level < 3; ++level) {
      const double half = draw.Uniform(0.28, 0.5) - 0.06 * level, height = draw.Uniform(0.5, 0.8);
      mesh.AddBox(Upright(stack[0], stack[1], z + 0.5 * height, draw.Uniform(-0.8, 0.8)),
                  Vector3d(half, half * draw.Uniform(0.8, 1.2), 0.5 * height), Material::kCardboard,
                  static_cast<std::uint32_t>(draw.Next() % 1000));
      z += height;
    }
  }
}

void AddMiddle(const Random& random, Mesh& mesh) {
  Random draw = random.Fork(200);
  for (double x : {-5.0, 0.0, 5.0})
    AddTable(x + draw.Uniform(-0.5, 0.5), draw.Uniform(-1.5, 1.5), draw.Uniform(-1, 1), mesh);
  for (int i = 0; i < 7; ++i) {
    const double half = draw.Uniform(0.15, 0.33);
    mesh.AddBox(Upright(-6.6 + 2.2 * i, draw.Uniform(2.2, 3.6) * (i % 2 == 0 ? 1 : -1), half,
                        draw.Uniform(-0.8, 0.8)),
                Vector3d(half * 1.3, half, half), Material::kCardboard, static_cast<std::uint32_t>(40 + i));
  }
  mesh.AddPrism(Upright(2.4, 0.2, 0, 0.7), {{-1.0, 0.0}, {1.0, 0.0}, {1.0, 0.55}}, 0.7, Material::kWood);
}

}  // namespace

Mesh HallMesh() {
  Mesh mesh;
  const Random random(20240502);
  AddRoom(mesh);
  AddEdges(random, mesh);
  AddMiddle(random, mesh);
  return mesh;
}

std::unique_ptr<World> MakeHall(InfraredLook infrared) {
  return std::make_unique<World>(HallMesh(), infrared);
}

}  // namespace mlic::sim
