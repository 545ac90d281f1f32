#include "mlic_sim/yard.h"

#include <cmath>

#include "mlic_sim/furniture.h"
#include "mlic_sim/ground.h"

namespace mlic::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

void AddBuildings(Mesh& mesh) {
  const Building buildings[] = {{{-37, 21.5}, {-14, 29.5}, 9.4, 0.0, Material::kBrick, 0},
                                {{-9, 22.5}, {10, 29.5}, 4.2, 2.6, Material::kPlaster, 0},
                                {{15, 20.8}, {37, 29.0}, 12.6, 0.0, Material::kBrick, 1},
                                {{-36, -29}, {-20, -21}, 6.3, 0.0, Material::kPlaster, 1},
                                {{-15, -29.5}, {4, -22}, 9.6, 0.0, Material::kConcrete, 0},
                                {{9, -29}, {35, -21.6}, 3.6, -2.9, Material::kBrick, 2},
                                {{33.5, -13}, {39.5, 11}, 6.4, 0.0, Material::kPlaster, 2},
                                {{-39.5, -9}, {-33, 15}, 3.3, 1.9, Material::kBrick, 3}};
  for (const Building& building : buildings) AddBuilding(building, mesh);
  // The wall around the yard, between the buildings.
  for (double side : {-1.0, 1.0}) {
    mesh.AddBox(Vector3d(-40.2, side * 30.1 - 0.1, -0.4), Vector3d(40.2, side * 30.1 + 0.1, 2.4),
                Material::kConcrete);
    mesh.AddBox(Vector3d(side * 40.1 - 0.1, -30.2, -0.4), Vector3d(side * 40.1 + 0.1, 30.2, 2.4),
                Material::kConcrete);
  }
}

void AddPavements(Mesh& mesh) {
  // Pavements with kerbs 12 cm high along the buildings; gaps are drives.
  for (double side : {-1.0, 1.0}) {
    for (double x : {-24.0, 0.0, 24.0}) {
      const Vector3d center(x, side * 20.0, 0.0);
      mesh.AddBox(center + Vector3d(-10, -0.8, -0.3), center + Vector3d(10, 0.8, 0.12), Material::kKerb);
    }
    mesh.AddBox(Vector3d(side * 31.8 - 0.6, -14, -0.3), Vector3d(side * 31.8 + 0.6, 14, 0.12),
                Material::kKerb);
    // Islands in the loops.
    mesh.AddCylinder(Upright(side * 15.0, 0, -0.3, 0.2), 2.3, 0.43, 24, Material::kKerb);
  }
  // A loading ramp and a stair.
  mesh.AddPrism(Upright(31.0, 17.0, 0, 0.5 * M_PI),
                {{-3, -0.3}, {1.5, -0.3}, {1.5, 1.1}, {0.5, 1.1}, {-3, 0.0}}, 1.2, Material::kConcrete);
  for (int step = 0; step < 6; ++step) {
    mesh.AddBox(Vector3d(-31.5 - 0.3 * step, 16, -0.3), Vector3d(-31.2 - 0.3 * step, 19, 0.17 * (step + 1)),
                Material::kConcrete);
  }
}

void AddStreetFurniture(const Random& random, Mesh& mesh) {
  std::uint32_t object = 0;
  for (double x : {-30.4, -17.0, -5.0, 8.0, 19.5, 30.4}) {
    for (double side : {-1.0, 1.0}) AddSignPole(x, side * 19.3, -side * 0.5 * M_PI + 0.2, ++object, mesh);
  }
  for (double side : {-1.0, 1.0}) {
    AddSignPole(side * 15.6, -0.8, side > 0 ? 2.5 : 0.4, ++object, mesh);
    AddTree(side * 14.4, 0.7, 5.0, random.Fork(900 + object), mesh);
    AddTree(side * 31.6, 6.0, 6.5, random.Fork(910 + object), mesh);
    AddLeaningBoard({side * 31.4, -4.0, side > 0 ? M_PI : 0.0, 0.35, 2.4, 1.9}, Material::kSignBoard,
                    40 + object, mesh);
    // Containers, askew.
    Eigen::Isometry3d T = Upright(side * 27.0, side * 17.0, 1.2, 0.35 * side);
    mesh.AddBox(T, Vector3d(1.2, 2.4, 1.25), Material::kCarPaint, 7 + object);
  }
  mesh.AddPrism(Upright(0.0, 12.2, 0, 0.3), {{-1.1, -0.2}, {1.1, -0.2}, {0.0, 1.5}}, 1.6,
                Material::kSignBoard, 77);
}

void AddParkedCars(const Random& random, bool flat_ground, Mesh& mesh) {
  Random draw = random.Fork(1);
  for (double side : {-1.0, 1.0}) {
    for (int slot = -9; slot <= 8; ++slot) {
      const bool taken = draw.Uniform() < 0.6, van = draw.Uniform() < 0.2;
      const double x = 2.6 * slot + 1.3 + draw.Uniform(-0.15, 0.15),
                   y = side * (15.7 + draw.Uniform(-0.25, 0.25));
      const double yaw = (draw.Uniform() < 0.5 ? 0.5 : -0.5) * M_PI + draw.Uniform(-0.06, 0.06);
      const std::uint32_t object = static_cast<std::uint32_t>(draw.Next() % 997);
      if (!taken) continue;
      AddCar(x, y, flat_ground ? 0.0 : UnevenGroundHeight(x, y), yaw, van, object, mesh);
    }
  }
}

}  // namespace

Mesh YardMesh(bool flat_ground) {
  Mesh mesh;
  if (flat_ground) {
    mesh.AddQuad({-41, -31, 0}, {41, -31, 0}, {41, 31, 0}, {-41, 31, 0}, Material::kYardGround);
  } else {
    mesh.AddHeightField({-41, -31}, {41, 31}, 0.25, UnevenGroundHeight<double>, Material::kYardGround);
  }
  const Random random(20240501);
  AddBuildings(mesh);
  AddPavements(mesh);
  AddStreetFurniture(random, mesh);
  AddParkedCars(random, flat_ground, mesh);
  return mesh;
}

}  // namespace mlic::sim
