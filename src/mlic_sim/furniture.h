#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "mlic_core/common/random.h"
#include "mlic_sim/mesh.h"

namespace mlic::sim {

// Things that the worlds are furnished with. All stand upright at (x, y); metres, radians.

// A building over a rectangle, with recessed windows, pilasters, a door in every facade and a roof of its own
// shape.
struct Building {
  Eigen::Vector2d low, high;
  double height;
  double roof_rise;  // height that a shed roof gains from low y to high y; 0 for a flat roof with a parapet
  Material wall;
  std::uint32_t object;
  double base = 0.0;  // of the ground it stands on; walls go on 0.4 m below
  double window_depth = 0.14;
  double bay = 3.4, storey = 3.1;  // of the grid of windows
};
void AddBuilding(const Building& building, Mesh& mesh);

// A saloon car (van: a box-shaped one) whose wheels stand at height z.
void AddCar(double x, double y, double z, double yaw, bool van, std::uint32_t object, Mesh& mesh);

// A trunk and a crown of many small leaves.
void AddTree(double x, double y, double height, Random random, Mesh& mesh);

// Leaves: `count` small facets, turned at random, within an ellipsoid that is somewhat lower than wide.
struct Crown {
  Eigen::Vector3d center;
  double radius;
  int count;
};
void AddCrown(const Crown& crown, Random& random, Mesh& mesh);

// A lamp pole with a sign board that looks along yaw.
void AddSignPole(double x, double y, double yaw, std::uint32_t object, Mesh& mesh);

void AddTable(double x, double y, double yaw, Mesh& mesh);

// A shelf of boards and posts, with boxes on it; it looks along yaw.
void AddShelf(double x, double y, double yaw, Random random, Mesh& mesh);

// A flat board of width by height that leans back by tilt from the vertical and looks along yaw; its lower
// edge is on the ground.
struct LeaningBoard {
  double x, y, yaw, tilt, width, height;
};
void AddLeaningBoard(const LeaningBoard& board, Material material, std::uint32_t object, Mesh& mesh);

}  // namespace mlic::sim
