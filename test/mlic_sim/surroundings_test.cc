#include "mlic_sim/surroundings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/world.h"

namespace mlic::sim::surroundings_test {
namespace {

using Eigen::Vector3d;

struct Place {
  WorldFamily family;
  Scenario scenario;
};

const Place kPlaces[] = {
    {WorldFamily::kYard, Scenario::kHandheld},     {WorldFamily::kYard, Scenario::kFigureEight},
    {WorldFamily::kHall, Scenario::kHandheld},     {WorldFamily::kStreet, Scenario::kHandheld},
    {WorldFamily::kStreet, Scenario::kPlanar},     {WorldFamily::kCarPark, Scenario::kFigureEight},
    {WorldFamily::kCarPark, Scenario::kCircle},    {WorldFamily::kCorridor, Scenario::kHandheld},
    {WorldFamily::kSlope, Scenario::kFigureEight}, {WorldFamily::kGrove, Scenario::kFigureEight},
    {WorldFamily::kGrove, Scenario::kHandheld}};

std::unique_ptr<Trajectory> MotionIn(const Surroundings& world, Scenario scenario, std::uint64_t seed) {
  const RigidTransform T_body_imu{Eigen::Quaterniond::Identity(), Vector3d(0, 0, 1.3)};
  return MakeTrajectory(scenario, seed, 40.0, T_body_imu, world.ground);
}

TEST(Surroundings, SeedDecidesTheLayout) {
  for (const Place& place : kPlaces) {
    const Surroundings a = MakeSurroundings(place.family, 1, place.scenario);
    const Surroundings same = MakeSurroundings(place.family, 1, place.scenario);
    const Surroundings b = MakeSurroundings(place.family, 2, place.scenario);
    EXPECT_EQ(a.mesh.vertices(), same.mesh.vertices());
    EXPECT_NE(a.mesh.vertices(), b.mesh.vertices());
  }
}

// Wherever a rig goes, there is room around it, ground (the car's wheels are on it) and something to see.
TEST(Surroundings, LeaveRoomForTheRigAndShowItSomething) {
  for (const Place& place : kPlaces) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      Surroundings surroundings = MakeSurroundings(place.family, seed, place.scenario);
      const auto motion = MotionIn(surroundings, place.scenario, seed);
      const World world(std::move(surroundings.mesh));
      SCOPED_TRACE(testing::Message() << "family " << static_cast<int>(place.family) << ", "
                                      << ScenarioName(place.scenario) << ", seed " << seed);
      double nearest = 1e9, seen = 0.0, rays = 0.0;
      for (double t = 0.0; t < 40.0; t += 0.4) {
        const Vector3d at = motion->PoseAt(t).translation;
        const auto ground = world.Cast(at, -Vector3d::UnitZ(), 5.0);
        ASSERT_TRUE(ground) << at.transpose();
        if (!IsCarriedByHand(place.scenario)) {
          EXPECT_NEAR(ground->range, 1.3, 0.15);
        }
        for (double angle = 0.0; angle < 2.0 * M_PI; angle += 0.2) {
          const auto hit = world.Cast(at, Vector3d(std::cos(angle), std::sin(angle), 0.0), 100.0);
          rays += 1.0;
          if (!hit) continue;
          seen += 1.0;
          nearest = std::min(nearest, hit->range);
        }
      }
      EXPECT_GT(nearest, 0.5);
      EXPECT_GT(seen / rays, 0.08);  // trunks only, in a grove
    }
  }
}

TEST(Surroundings, CarsLeanWithTheHill) {
  const Surroundings world = MakeSurroundings(WorldFamily::kSlope, 4, Scenario::kFigureEight);
  const auto motion = MotionIn(world, Scenario::kFigureEight, 4);
  double steepest = 0.0;
  for (double t = 0.0; t < 40.0; t += 0.5) {
    const RigidTransform T = motion->PoseAt(t);
    const Vector3d up = T.rotation * Vector3d::UnitZ();
    const double x = T.translation.x(), y = T.translation.y();
    // The hill's own normal, but for the suspension's 1.5 deg and the place 1.3 m above it.
    const Vector3d normal = Vector3d(-world.ground.terrain.Slope(x, y, 1.0, 0.0),
                                     -world.ground.terrain.Slope(x, y, 0.0, 1.0), 1.0)
                                .normalized();
    EXPECT_LT(std::acos(up.dot(normal)) * 180.0 / M_PI, 2.0);
    steepest = std::max(steepest, std::acos(normal.z()) * 180.0 / M_PI);
  }
  EXPECT_GT(steepest, 3.0);
}

TEST(Surroundings, VelocityOnAHillIsThatOfTheMotion) {
  for (const Scenario scenario : {Scenario::kFigureEight, Scenario::kHandheld}) {
    const Surroundings world = MakeSurroundings(WorldFamily::kSlope, 4, scenario);
    const auto motion = MotionIn(world, scenario, 4);
    for (double t = 1.0; t < 20.0; t += 1.7) {
      constexpr double h = 1e-4;
      const MotionState state = motion->StateAt(t), before = motion->StateAt(t - h),
                        after = motion->StateAt(t + h);
      const Vector3d velocity = (after.T_map_imu.translation - before.T_map_imu.translation) / (2.0 * h);
      EXPECT_LT((state.velocity - velocity).norm(), 1e-6);
      EXPECT_LT((state.acceleration - (after.velocity - before.velocity) / (2.0 * h)).norm(), 1e-5);
      const Vector3d turn =
          Log(Eigen::Quaterniond(before.T_map_imu.rotation.conjugate() * after.T_map_imu.rotation));
      EXPECT_LT((state.angular_velocity - turn / (2.0 * h)).norm(), 1e-5);
    }
  }
}

TEST(Surroundings, RefuseScenariosThatTheyHaveNoRoomFor) {
  EXPECT_THROW(MakeSurroundings(WorldFamily::kCorridor, 1, Scenario::kFigureEight), InputError);
  EXPECT_THROW(MakeSurroundings(WorldFamily::kSlope, 1, Scenario::kPlanar), InputError);
  EXPECT_THROW(WorldFamilyFromName("desert"), InputError);
  EXPECT_EQ(WorldFamilyFromName("car_park"), WorldFamily::kCarPark);
}

TEST(MovingObjects, AreWhereTheirLanesAre) {
  // One car on a lane along x at y = 10, seen from the origin's side.
  const std::vector<Lane> lanes = {{Lane::Kind::kTraffic, {-40, 10, 0}, {40, 10, 0}}};
  const MovingObjects cars(lanes, 1, Random(3));
  std::set<int> places;
  for (double t = 0.0; t < 40.0; t += 0.5) {
    for (double x = -40.0; x < 40.0; x += 1.0) {
      const auto hit = cars.At(t).Cast(Vector3d(x, 0, 0.6), Vector3d::UnitY(), 100.0);
      if (!hit) continue;
      EXPECT_NEAR(hit->range, 10.0 - 0.88, 1e-9);
      EXPECT_NEAR((hit->normal - Vector3d(0, -1, 0)).norm(), 0.0, 1e-9);
      places.insert(static_cast<int>(x));
    }
  }
  EXPECT_GT(places.size(), 30u);
  EXPECT_FALSE(cars.At(0.0).Cast(Vector3d(0, 0, 0.6), -Vector3d::UnitY(), 100.0));
  EXPECT_FALSE(cars.At(0.0).Cast(Vector3d(0, 0, 3.0), Vector3d::UnitY(), 100.0));
}

TEST(MovingObjects, HideWhatIsBehindThemAndNotWhatIsInFront) {
  const std::vector<Lane> lanes = {{Lane::Kind::kDoor, {4, -1, 0}, {4, 1, 0}}};
  const auto wall = [](double x) {
    Mesh mesh;
    mesh.AddQuad({x, -50, -50}, {x, 50, -50}, {x, 50, 50}, {x, -50, 50}, Material::kPlaster);
    return mesh;
  };
  const World behind(wall(10.0), InfraredLook::kRelated, MovingObjects(lanes, 1, Random(1)));
  const World in_front(wall(2.0), InfraredLook::kRelated, MovingObjects(lanes, 1, Random(1)));
  const Vector3d origin(0, -0.9, 1.0);
  for (double t = 0.0; t < 20.0; t += 1.0) {
    const auto hit = behind.CastAt(t, origin, Vector3d::UnitX(), 50.0);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->material, Material::kDoor);
    EXPECT_NEAR(hit->range, 4.0, 0.2);
    EXPECT_NEAR(in_front.CastAt(t, origin, Vector3d::UnitX(), 50.0)->range, 2.0, 1e-9);
    EXPECT_NEAR(behind.Cast(origin, Vector3d::UnitX(), 50.0)->range, 10.0, 1e-9);
  }
}

}  // namespace
}  // namespace mlic::sim::surroundings_test
