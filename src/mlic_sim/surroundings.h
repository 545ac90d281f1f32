#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_sim/furniture.h"
#include "mlic_sim/ground.h"
#include "mlic_sim/lighting.h"
#include "mlic_sim/mesh.h"
#include "mlic_sim/moving_objects.h"
#include "mlic_sim/trajectory.h"

namespace mlic::sim {

// Families of worlds whose layout, materials and clutter follow from a seed.
enum class WorldFamily {
  kOfScenario,  // the one yard (for cars) or the one hall (by hand), whatever the seed
  kYard,        // open ground among buildings
  kHall,        // one room with pillars, shelves and crates; by hand only
  kStreet,      // a street canyon with a crossing
  kCarPark,     // one storey, with pillars, beams and a ramp
  kCorridor,    // narrow, with niches and doors; by hand only
  kSlope,       // hills with buildings, walls and ramps at different heights
  kGrove        // trunks, foliage and rough ground, hardly a plane
};

// Throws InputError for an unknown name.
WorldFamily WorldFamilyFromName(const std::string& name);

// What a world is made of, before it can be cast.
struct Surroundings {
  Mesh mesh;
  Lighting lighting;
  MotionGround ground;
  std::vector<Lane> lanes;  // room for what moves
};

// The world in which a scenario takes place. seed: not used by kOfScenario. Throws InputError for a scenario
// that the family has no room or no ground for.
Surroundings MakeSurroundings(WorldFamily family, std::uint64_t seed, Scenario scenario);

// Whether a disc of the radius (m) about (x, y) stays clear of where the rigs of all scenarios go.
bool IsClear(double x, double y, double radius);

// One function for each family; flat: without unevenness.
Surroundings MakeRandomYard(const Random& random, bool flat);
Surroundings MakeStreet(const Random& random, bool flat);
Surroundings MakeSlope(const Random& random);
Surroundings MakeGrove(const Random& random);
Surroundings MakeRandomHall(const Random& random);
Surroundings MakeCarPark(const Random& random, bool flat);
Surroundings MakeCorridor(const Random& random);

// The next number of an object, which gives it its colour.
inline std::uint32_t AnyObject(Random& draw) { return static_cast<std::uint32_t>(draw.Next() % 997); }

}  // namespace mlic::sim
