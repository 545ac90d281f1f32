// Worlds under a roof: hall, car park, corridor.
#include <algorithm>
#include <cmath>

#include "mlic_sim/surroundings.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated worlds.

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Material AnyWall(Random& draw) {
  const Material walls[] = {Material::kHallWall, Material::kBrick, Material::kConcrete, Material::kPlaster};
  return walls[draw.Next() % 4];
}

struct Room {
  double x, y, z;  // half length, half width, height
};

void AddWallsAndCeiling(const Room& room, Random& draw, Mesh& mesh) {
  const auto [x, y, z] = room;
  mesh.AddQuad({-x, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}, Material::kConcrete);
  const Vector2d corners[] = {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
  for (int i = 0; i < 4; ++i) {
    const Vector2d &a = corners[i], &b = corners[(i + 1) % 4];
    mesh.AddQuad({a.x(), a.y(), -0.2}, {b.x(), b.y(), -0.2}, {b.x(), b.y(), z}, {a.x(), a.y(), z},
                 AnyWall(draw), AnyObject(draw));
  }
}

void AddPipe(const Vector3d& from, double length, double radius, Mesh& mesh) {
  Isometry3d pipe = Isometry3d::Identity();
  pipe.translate(from).rotate(Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitY()));
  mesh.AddCylinder(pipe, radius, length, 18, Material::kMetal);
}

void AddLamps(const Room& room, double step, Lighting& lighting) {
  const int columns = std::max(1, static_cast<int>(2.0 * room.x / step));
  const int rows = std::max(1, static_cast<int>(2.0 * room.y / step));
  lighting.lamps.clear();
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      lighting.lamps.push_back(Vector3d(room.x * ((2 * i + 1.0) / columns - 1.0),
                                        room.y * ((2 * j + 1.0) / rows - 1.0), room.z - 0.7)
                                   .cast<float>());
    }
  }
}

void AddCrates(double x, double y, Random& draw, Mesh& mesh) {
  double z = 0.0;
  const int levels = 1 + static_cast<int>(draw.Next() % 3);
  for (int level = 0; level < levels; ++level) {
    const double half = draw.Uniform(0.2, 0.5), height = draw.Uniform(0.3, 0.8);
    mesh.AddBox(Upright(x, y, z + 0.5 * height, draw.Uniform(-1.5, 1.5)),
                Vector3d(half, half * draw.Uniform(0.7, 1.3), 0.5 * height), Material::kCardboard,
                AnyObject(draw));
    z += height;
  }
}

// One piece of a corridor's wall from x0 to x1 on the given side: set back by `depth` (0: flush).
struct Piece {
  double x0, x1, side, half_width, depth, height;
  bool door;
};

void AddPiece(const Piece& p, Material wall, std::uint32_t object, Mesh& mesh) {
  const double y = p.side * (p.half_width + p.depth), front = p.side * p.half_width;
  const double lintel = p.door ? 2.1 : 0.0;
  if (p.door)
    mesh.AddQuad({p.x0, y, 0}, {p.x1, y, 0}, {p.x1, y, lintel}, {p.x0, y, lintel}, Material::kDoor, object);
  mesh.AddQuad({p.x0, y, lintel}, {p.x1, y, lintel}, {p.x1, y, p.height}, {p.x0, y, p.height}, wall, object);
  if (p.depth == 0.0) return;
  for (double x : {p.x0, p.x1}) {
    mesh.AddQuad({x, front, 0}, {x, y, 0}, {x, y, p.height}, {x, front, p.height}, wall, object);
  }
}

void AddCorridorWall(double side, double half_width, const Room& room, Random& draw, Surroundings& world) {
  const Material wall = AnyWall(draw);
  const std::uint32_t object = AnyObject(draw);
  for (double x = -room.x; x < room.x;) {
    const double kind = draw.Uniform();
    const bool door = kind < 0.25, niche = !door && kind < 0.6;
    const double end = std::min(room.x, x + (door ? 1.0 : draw.Uniform(0.8, 3.2)));
    const double depth = door ? draw.Uniform(0.04, 0.25) : niche ? draw.Uniform(0.15, 1.2) : 0.0;
    AddPiece({x, end, side, half_width, depth, room.z, door}, wall, object, world.mesh);
    const double middle = 0.5 * (x + end);
    if (niche && depth > 0.7 && draw.Uniform() < 0.6) {
      AddCrates(middle, side * (half_width + 0.6 * depth), draw, world.mesh);
    } else if (!door && !niche && draw.Uniform() < 0.4) {
      world.mesh.AddBox(Vector3d(middle - 0.3, side * half_width - 0.03, 1.2),
                        Vector3d(middle + 0.3, side * half_width + 0.03, 2.0), Material::kSignBoard,
                        AnyObject(draw));
    }
    if (door) {
      // Hinged so that the leaf swings into the corridor.
      const Vector3d left(x, side * half_width, 0), right(end, side * half_width, 0);
      world.lanes.push_back({Lane::Kind::kDoor, side > 0 ? right : left, side > 0 ? left : right});
    }
    x = end;
  }
}

}  // namespace

Surroundings MakeRandomHall(const Random& random) {
  Surroundings world;
  world.lighting = HallLighting();
  Mesh& mesh = world.mesh;
  Random draw = random.Fork(5);
  const Room room{draw.Uniform(10.0, 17.0), draw.Uniform(6.8, 11.0), draw.Uniform(3.6, 8.0)};
  mesh.AddQuad({-room.x, -room.y, 0}, {room.x, -room.y, 0}, {room.x, room.y, 0}, {-room.x, room.y, 0},
               draw.Uniform() < 0.6 ? Material::kHallFloor : Material::kConcrete);
  AddWallsAndCeiling(room, draw, mesh);
  AddLamps(room, 5.5, world.lighting);
  const double spacing = draw.Uniform(4.0, 7.0);
  const bool pillars = draw.Uniform() < 0.6;
  for (double x = -room.x + 0.5 * spacing; x < room.x; x += spacing) {
    mesh.AddBox(Vector3d(x - 0.15, -room.y, room.z - 0.5), Vector3d(x + 0.15, room.y, room.z),
                Material::kConcrete);
    for (double side : {-1.0, 1.0}) {
      if (!pillars) continue;
      const double y = side * (room.y - 1.5), half = 0.22;
      mesh.AddBox(Vector3d(x - half, y - half, 0), Vector3d(x + half, y + half, room.z), Material::kConcrete);
    }
  }
  AddPipe({-room.x, draw.Uniform(-3.0, 3.0), room.z - 0.9}, 2.0 * room.x, draw.Uniform(0.1, 0.35), mesh);
  // Along the walls: shelves, boards, crates.
  const int things = 10 + static_cast<int>(draw.Next() % 12);
  for (int i = 0; i < things; ++i) {
    const bool long_side = draw.Uniform() < 0.65;
    const double side = draw.Uniform() < 0.5 ? -1.0 : 1.0, kind = draw.Uniform();
    const double x = long_side ? draw.Uniform(-room.x + 1.5, room.x - 1.5) : side * (room.x - 0.7);
    const double y = long_side ? side * (room.y - 0.7) : draw.Uniform(-room.y + 1.5, room.y - 1.5);
    const double yaw = long_side ? -side * 0.5 * M_PI : (side > 0 ? M_PI : 0.0);
    if (kind < 0.4) {
      AddShelf(x, y, yaw, draw.Fork(static_cast<std::uint64_t>(i)), mesh);
    } else if (kind < 0.7) {
      AddLeaningBoard({x, y, yaw + draw.Uniform(-0.4, 0.4), draw.Uniform(0.25, 0.6), draw.Uniform(1.2, 2.4),
                       draw.Uniform(1.6, 2.8)},
                      draw.Uniform() < 0.5 ? Material::kWood : Material::kSignBoard, AnyObject(draw), mesh);
    } else {
      AddCrates(x, y, draw, mesh);
    }
  }
  // Low things in the middle: rigs are carried above them.
  const int tables = static_cast<int>(draw.Next() % 6);
  for (int i = 0; i < tables; ++i)
    AddTable(draw.Uniform(-7, 7), draw.Uniform(-3, 3), draw.Uniform(-1.5, 1.5), mesh);
  world.lanes = {{Lane::Kind::kPeople, {-7, 4.8, 0}, {7, 5.0, 0}},
                 {Lane::Kind::kPeople, {8.8, -5, 0}, {8.6, 5, 0}},
                 {Lane::Kind::kPeople, {7, -4.9, 0}, {-7, -4.8, 0}}};
  return world;
}

Surroundings MakeCarPark(const Random& random, bool flat) {
  Surroundings world;
  world.lighting = HallLighting();
  Mesh& mesh = world.mesh;
  Random draw = random.Fork(6);
  const Room room{draw.Uniform(31.5, 36.0), draw.Uniform(17.5, 21.0), draw.Uniform(2.9, 3.6)};
  if (flat) {
    mesh.AddQuad({-room.x, -room.y, 0}, {room.x, -room.y, 0}, {room.x, room.y, 0}, {-room.x, room.y, 0},
                 Material::kYardGround);
  } else {
    mesh.AddHeightField({-room.x, -room.y}, {room.x, room.y}, 0.4, UnevenGroundHeight<double>,
                        Material::kYardGround);
  }
  AddWallsAndCeiling(room, draw, mesh);
  AddLamps(room, 7.0, world.lighting);
  const double step_x = draw.Uniform(5.0, 8.0), step_y = draw.Uniform(4.8, 7.0);
  const bool round = draw.Uniform() < 0.4;
  const double half = draw.Uniform(0.2, 0.4);
  for (double x = -room.x + 0.5 * step_x; x < room.x; x += step_x) {
    mesh.AddBox(Vector3d(x - 0.2, -room.y, room.z - 0.45), Vector3d(x + 0.2, room.y, room.z),
                Material::kConcrete);
    for (double y = -room.y + 0.5 * step_y; y < room.y; y += step_y) {
      if (!IsClear(x, y, half)) continue;
      if (round) {
        mesh.AddCylinder(Upright(x, y, -0.2, 0), half, room.z + 0.2, 24, Material::kConcrete);
      } else {
        mesh.AddBox(Vector3d(x - half, y - half, -0.2), Vector3d(x + half, y + half, room.z),
                    Material::kConcrete);
      }
    }
  }
  for (int i = 0; i < 3; ++i) {
    AddPipe({-room.x, draw.Uniform(-room.y + 1, room.y - 1), room.z - 0.6}, 2.0 * room.x,
            draw.Uniform(0.05, 0.2), mesh);
  }
  const double taken = draw.Uniform(0.2, 0.8);
  for (double side : {-1.0, 1.0}) {
    for (double x = -room.x + 2.0; x < room.x - 2.0; x += 2.6) {
      const double y = side * (room.y - 2.6);
      if (draw.Uniform() > taken || !IsClear(x, y, 2.2)) continue;
      AddCar(x, y, flat ? 0.0 : UnevenGroundHeight(x, y),
             (draw.Uniform() < 0.5 ? 0.5 : -0.5) * M_PI + draw.Uniform(-0.05, 0.05), false, AnyObject(draw),
             mesh);
    }
    // The ramps to the next storeys, along the short walls.
    const double x = side * (room.x - 3.0), rise = room.z;
    mesh.AddPrism(Upright(x, 0, 0, draw.Uniform() < 0.5 ? 0.5 * M_PI : -0.5 * M_PI),
                  {{-9.0, -0.2}, {9.0, -0.2}, {9.0, rise}, {-7.0, 0.05}}, 2.2, Material::kConcrete);
    mesh.AddBox(Vector3d(x - 0.4, -room.y, 0.0), Vector3d(x + 0.4, -room.y + 0.15, 2.1), Material::kDoor);
  }
  world.lanes = {{Lane::Kind::kTraffic, {27, 12.2, 0}, {-27, 12.2, 0}},
                 {Lane::Kind::kPeople, {-20, 13.9, 0}, {10, 13.7, 0}}};
  return world;
}

Surroundings MakeCorridor(const Random& random) {
  Surroundings world;
  world.lighting = HallLighting();
  Mesh& mesh = world.mesh;
  Random draw = random.Fork(7);
  const double half_width = draw.Uniform(1.5, 2.3);
  const Room room{draw.Uniform(9.5, 14.0), half_width + 1.3, draw.Uniform(2.6, 3.4)};
  mesh.AddQuad({-room.x, -room.y, 0}, {room.x, -room.y, 0}, {room.x, room.y, 0}, {-room.x, room.y, 0},
               draw.Uniform() < 0.5 ? Material::kHallFloor : Material::kConcrete);
  AddWallsAndCeiling(room, draw, mesh);
  AddLamps({room.x, half_width, room.z + 0.4}, 3.0, world.lighting);
  world.lighting.lamp *= 0.35f;
  for (double side : {-1.0, 1.0}) {
    AddCorridorWall(side, half_width, room, draw, world);
    mesh.AddBox(Vector3d(side * room.x - 0.1, -0.9, 0), Vector3d(side * room.x + 0.1, 0.9, 2.2),
                Material::kDoor);
  }
  AddPipe({-room.x, draw.Uniform(0.5, 1.0) * half_width - 0.3, room.z - 0.2}, 2.0 * room.x,
          draw.Uniform(0.04, 0.12), mesh);
  // The walk sways by up to 3.2 m in the hall; here 0.75 m are left to either wall.
  world.ground.breadth = (half_width - 0.75) / 3.2;
  return world;
}

}  // namespace mlic::sim
