#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_sim/ray_hit.h"

namespace mlic::sim {

// Where a world has room for something that moves. Metres, map frame; on the ground.
struct Lane {
  enum class Kind {
    kTraffic,  // cars, from `from` to `to` and in again at `from`
    kPeople,   // to and fro
    kDoor      // a leaf that swings by up to 45 deg about the hinge `from`; shut, it reaches to `to`
  };
  Kind kind = Kind::kTraffic;
  Eigen::Vector3d from, to;
};

// Boxes that move on lanes, cast analytically: nothing is built anew for each instant. Thread-safe.
class MovingObjects {
 public:
  MovingObjects() = default;
  // `count` objects, dealt to the lanes in turn; speeds, sizes and phases follow from `random`.
  MovingObjects(const std::vector<Lane>& lanes, int count, const Random& random);

  // All of them where they are at one time. Refers to them.
  class Instant;
  Instant At(double time) const;

  bool IsEmpty() const { return objects_.empty(); }

 private:
  struct Part {
    Eigen::Vector3d center, half;  // m, in the object's frame
    Material material;
  };
  struct Object {
    Lane lane;
    double speed = 0.0;  // m/s, of a door rad/s; the largest of what goes to and fro
    double phase = 0.0;  // 0 to 1
    std::uint32_t number = 0;
    std::vector<Part> parts;
    double reach = 0.0;  // m, from the object's origin to its farthest corner

    Eigen::Isometry3d PoseAt(double time) const;
  };

  std::vector<Object> objects_;
};

class MovingObjects::Instant {
 public:
  // The first surface along the ray (direction: unit), or nothing within max_range (m).
  std::optional<RayHit> Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                             double max_range) const;

 private:
  friend class MovingObjects;
  struct Placed {
    const Object* object;
    Eigen::Isometry3d T_map_object;
  };
  std::vector<Placed> objects_;
};

}  // namespace mlic::sim
