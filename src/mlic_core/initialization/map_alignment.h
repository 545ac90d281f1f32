#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/lidar/plane_map.h"

namespace mlic {

// Where one map lies in another, from the planes of both.
struct MapAlignment {
  RigidTransform T_a_b;
  // Of the planes of b, those that lie on a plane of a which faces the same way. Planes count by how rare
  // their direction is, so that a large ground does not outweigh the walls.
  double share = 0.0;
  double share_elsewhere = 0.0;  // at the best place that is another one

  // One place, and clearly the best.
  bool IsClear() const;
};

// Rotations that cover all of them, about 25 deg apart.
std::vector<RigidTransform> AllRotations();

// The guess and its surroundings by one sigma (rad).
std::vector<RigidTransform> RotationsAbout(const RigidTransform& guess, const Eigen::Vector3d& sigma);

// Of the planes of b at that place, those that lie on a plane of a (MapAlignment::share).
double ShareOfPlanes(const std::vector<MapPlane>& a, const std::vector<MapPlane>& b,
                     const RigidTransform& T_a_b);

// From each start planes of b are drawn onto those of a (point to plane, the pairs by place and direction;
// first within metres, then within decimetres). plausible: whether a place is possible for other reasons;
// others are not compared. Nothing where no place is, or a map has hardly any planes. The result does not
// depend on the number of threads.
std::optional<MapAlignment> AlignMaps(const std::vector<MapPlane>& a, const std::vector<MapPlane>& b,
                                      const std::vector<RigidTransform>& starts,
                                      const std::function<bool(const RigidTransform&)>& plausible);

}  // namespace mlic
