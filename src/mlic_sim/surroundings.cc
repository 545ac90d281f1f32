#include "mlic_sim/surroundings.h"

#include <cmath>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_sim/hall.h"
#include "mlic_sim/yard.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated worlds.

using Eigen::Vector2d;

constexpr std::pair<WorldFamily, const char*> kFamilies[] = {{WorldFamily::kOfScenario, "of_scenario"},
                                                             {WorldFamily::kYard, "yard"},
                                                             {WorldFamily::kHall, "hall"},
                                                             {WorldFamily::kStreet, "street"},
                                                             {WorldFamily::kCarPark, "car_park"},
                                                             {WorldFamily::kCorridor, "corridor"},
                                                             {WorldFamily::kSlope, "slope"},
                                                             {WorldFamily::kGrove, "grove"}};

// Places along the figure-eight, 0.5 m apart.
const std::vector<Vector2d>& PathOfCars() {
  static const std::vector<Vector2d> path = [] {
    std::vector<Vector2d> places;
    const auto trajectory = MakeTrajectory(Scenario::kPlanar, 1, 60.0, {});
    for (double t = 0.0; t < 40.0; t += 0.1) places.push_back(trajectory->PoseAt(t).translation.head<2>());
    return places;
  }();
  return path;
}

}  // namespace

WorldFamily WorldFamilyFromName(const std::string& name) {
  std::string known;
  for (const auto& [family, family_name] : kFamilies) {
    if (name == family_name) return family;
    known += (known.empty() ? "" : ", ") + std::string(family_name);
  }
  throw InputError("--world: unknown world '" + name + "': expected one of " + known);
}

bool IsClear(double x, double y, double radius) {
  const double room = radius + 1.8;  // half a car, with what is mounted on it
  // The walk by hand, the straight lane, the circle.
  if (std::abs(x) < 7.6 + radius && std::abs(y) < 4.2 + radius) return false;
  if (std::abs(x) < 31.0 && std::abs(y + 11.5) < room) return false;
  if (std::abs(std::hypot(x - 15.0, y) - 8.0) < room) return false;
  for (const Vector2d& place : PathOfCars()) {
    if ((place - Vector2d(x, y)).squaredNorm() < room * room) return false;
  }
  return true;
}

Surroundings MakeSurroundings(WorldFamily family, std::uint64_t seed, Scenario scenario) {
  const Random random(Random(seed).Fork(5));
  const bool by_hand = IsCarriedByHand(scenario), flat = IsOnFlatGround(scenario);
  const bool narrow = family == WorldFamily::kHall || family == WorldFamily::kCorridor;
  const bool hilly = family == WorldFamily::kSlope || family == WorldFamily::kGrove;
  if (narrow && !by_hand) {
    throw InputError("--world: halls and corridors have no room for a car; take a scenario by hand");
  }
  if (hilly && !by_hand && scenario != Scenario::kFigureEight) {
    throw InputError("--world: on hills only figure_eight and the scenarios by hand follow the ground");
  }
  switch (family) {
    case WorldFamily::kOfScenario: {
      if (by_hand) return {HallMesh(), HallLighting(), {}, {}};
      return {YardMesh(flat), YardLighting(), {}, {}};
    }
    case WorldFamily::kYard:
      return MakeRandomYard(random, flat);
    case WorldFamily::kHall:
      return MakeRandomHall(random);
    case WorldFamily::kStreet:
      return MakeStreet(random, flat);
    case WorldFamily::kCarPark:
      return MakeCarPark(random, flat);
    case WorldFamily::kCorridor:
      return MakeCorridor(random);
    case WorldFamily::kSlope:
      return MakeSlope(random);
    case WorldFamily::kGrove:
      return MakeGrove(random);
  }
  throw InternalError("world family without a world");
}

}  // namespace mlic::sim
