#include "mlic_sim/moving_objects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of what moves in the simulated worlds.

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kTrafficSpeed[2] = {2.0, 9.0};  // m/s
constexpr double kWalkingSpeed[2] = {0.6, 1.6};  // m/s
constexpr double kSwingingRate[2] = {0.3, 0.9};  // rad/s

// Where the ray enters the box from -half to +half: the range and the face's outward normal. Nothing where
// it misses or starts inside.
std::optional<std::pair<double, Vector3d>> EnterBox(const Vector3d& origin, const Vector3d& direction,
                                                    const Vector3d& half) {
  double enter = 0.0, leave = std::numeric_limits<double>::infinity();
  int axis = -1;
  for (int k = 0; k < 3; ++k) {
    if (direction[k] == 0.0) {
      if (std::abs(origin[k]) > half[k]) return std::nullopt;
      continue;
    }
    const double side = direction[k] > 0.0 ? 1.0 : -1.0;
    const double first = (-side * half[k] - origin[k]) / direction[k];
    const double second = (side * half[k] - origin[k]) / direction[k];
    if (first > enter) enter = first, axis = k;
    leave = std::min(leave, second);
  }
  if (axis < 0 || enter > leave) return std::nullopt;
  Vector3d normal = Vector3d::Zero();
  normal[axis] = direction[axis] > 0.0 ? -1.0 : 1.0;
  return std::make_pair(enter, normal);
}

}  // namespace

MovingObjects::MovingObjects(const std::vector<Lane>& lanes, int count, const Random& random) {
  for (int i = 0; i < count && !lanes.empty(); ++i) {
    Random draw = random.Fork(static_cast<std::uint64_t>(i));
    Object object;
    object.lane = lanes[static_cast<std::size_t>(i) % lanes.size()];
    object.phase = draw.Uniform();
    object.number = static_cast<std::uint32_t>(draw.Next() % 997);
    const double size = draw.Uniform(0.9, 1.1);
    switch (object.lane.kind) {
      case Lane::Kind::kTraffic:
        object.speed = draw.Uniform(kTrafficSpeed[0], kTrafficSpeed[1]);
        object.parts = {{{0, 0, 0.62}, Vector3d(2.2 * size, 0.88, 0.34), Material::kCarPaint},
                        {{-0.3, 0, 1.2}, Vector3d(1.2 * size, 0.76, 0.26), Material::kGlass}};
        break;
      case Lane::Kind::kPeople:
        object.speed = draw.Uniform(kWalkingSpeed[0], kWalkingSpeed[1]);
        object.parts = {{{0, 0, 0.72 * size}, Vector3d(0.14, 0.22, 0.72 * size), Material::kPlaster},
                        {{0, 0, 1.6 * size}, Vector3d(0.1, 0.09, 0.14 * size), Material::kBark}};
        break;
      case Lane::Kind::kDoor:
        object.speed = draw.Uniform(kSwingingRate[0], kSwingingRate[1]);
        object.parts = {{{0.5 * (object.lane.to - object.lane.from).norm(), 0, 1.05},
                         Vector3d(0.5 * (object.lane.to - object.lane.from).norm(), 0.02, 1.03),
                         Material::kDoor}};
        break;
    }
    for (const Part& part : object.parts) {
      object.reach = std::max(object.reach, part.center.norm() + part.half.norm());
    }
    objects_.push_back(object);
  }
}

Isometry3d MovingObjects::Object::PoseAt(double time) const {
  const Vector3d along = lane.to - lane.from;
  const double length = along.norm();
  double yaw = std::atan2(along.y(), along.x()), share = 0.0;
  switch (lane.kind) {
    case Lane::Kind::kTraffic:
      share = phase + speed * time / length;
      share -= std::floor(share);
      break;
    case Lane::Kind::kPeople:
      // A sine whose largest speed is `speed`.
      share = 0.5 + 0.5 * std::sin(2.0 * speed / length * time + 2.0 * M_PI * phase);
      break;
    case Lane::Kind::kDoor:
      yaw += 0.125 * M_PI * (1.0 + std::sin(speed * time + 2.0 * M_PI * phase));
      break;
  }
  Isometry3d T = Isometry3d::Identity();
  T.translate(Vector3d(lane.from + share * along)).rotate(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  return T;
}

MovingObjects::Instant MovingObjects::At(double time) const {
  Instant instant;
  for (const Object& object : objects_) instant.objects_.push_back({&object, object.PoseAt(time)});
  return instant;
}

std::optional<RayHit> MovingObjects::Instant::Cast(const Vector3d& origin, const Vector3d& direction,
                                                   double max_range) const {
  std::optional<RayHit> nearest;
  for (const Placed& placed : objects_) {
    const Object& object = *placed.object;
    const Isometry3d& T = placed.T_map_object;
    // What passes outside the object's sphere needs no closer look.
    const Vector3d to_object = T.translation() - origin;
    const double ahead = to_object.dot(direction);
    if (ahead < -object.reach ||
        (to_object - ahead * direction).squaredNorm() > object.reach * object.reach) {
      continue;
    }
    const Isometry3d inverse = T.inverse(Eigen::Isometry);
    const Vector3d own_origin = inverse * origin, own_direction = inverse.linear() * direction;
    for (const Part& part : object.parts) {
      const auto entry = EnterBox(own_origin - part.center, own_direction, part.half);
      if (!entry || entry->first > (nearest ? nearest->range : max_range)) continue;
      nearest = RayHit{entry->first, own_origin + entry->first * own_direction, T.linear() * entry->second,
                       part.material, object.number};
    }
  }
  return nearest;
}

}  // namespace mlic::sim
