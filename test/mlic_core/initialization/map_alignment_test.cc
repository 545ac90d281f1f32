#include "mlic_core/initialization/map_alignment.h"

#include <gtest/gtest.h>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::map_alignment_test {
namespace {

MapPlane Patch(const Eigen::Vector3d& center, const Eigen::Vector3d& normal) {
  MapPlane patch;
  patch.center = center;
  patch.plane.normal = normal.normalized();
  patch.plane.offset = patch.plane.normal.dot(center);
  return patch;
}

// A yard seen from its middle: ground, and walls and boxes that face ways of their own.
std::vector<MapPlane> Yard(bool with_walls) {
  Random random(3);
  std::vector<MapPlane> planes;
  for (int x = -10; x <= 10; x += 2) {
    for (int y = -10; y <= 10; y += 2) planes.push_back(Patch({1.0 * x, 1.0 * y, -1.7}, {0, 0, 1}));
  }
  if (!with_walls) return planes;
  for (int wall = 0; wall < 12; ++wall) {
    const double bearing = 0.5 * wall, turned = bearing + random.Uniform(-0.6, 0.6);
    const double range = random.Uniform(5.0, 14.0);
    const Eigen::Vector3d middle(range * std::cos(bearing), range * std::sin(bearing), 0.0);
    const Eigen::Vector3d normal(-std::cos(turned), -std::sin(turned), random.Uniform(-0.1, 0.1));
    for (int k = -2; k <= 2; ++k) {
      for (int z = -1; z <= 2; ++z) {
        const Eigen::Vector3d along(-normal.y(), normal.x(), 0.0);
        planes.push_back(Patch(middle + 0.7 * k * along + Eigen::Vector3d(0, 0, z), normal));
      }
    }
  }
  return planes;
}

// As another LiDAR at T_a_b has them: cut elsewhere, a part of them not seen, points noisy.
std::vector<MapPlane> SeenFrom(const RigidTransform& T_a_b, const std::vector<MapPlane>& planes) {
  Random random(5);
  const RigidTransform T_b_a = T_a_b.Inverse();
  std::vector<MapPlane> seen;
  for (const MapPlane& plane : planes) {
    if (random.Uniform(0.0, 1.0) < 0.4) continue;
    const Eigen::Vector3d& n = plane.plane.normal;
    Eigen::Vector3d beside(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5));
    beside += (random.Uniform(-0.02, 0.02) - n.dot(beside)) * n;
    seen.push_back(Patch(T_b_a * (plane.center + beside), T_b_a.rotation * n));
  }
  return seen;
}

bool Anywhere(const RigidTransform&) { return true; }

const RigidTransform kTrue{FromRollPitchYaw({2.1, -0.7, 1.3}), {0.4, -0.9, 0.3}};

TEST(MapAlignment, FindsAnyRotationWithoutAGuess) {
  const std::vector<MapPlane> a = Yard(true);
  const auto found = AlignMaps(a, SeenFrom(kTrue, a), AllRotations(), Anywhere);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->IsClear());
  EXPECT_LT(AngleBetween(found->T_a_b.rotation, kTrue.rotation), 0.01);
  EXPECT_LT((found->T_a_b.translation - kTrue.translation).norm(), 0.05);
}

TEST(MapAlignment, FindsThePlaceNearAGuess) {
  const std::vector<MapPlane> a = Yard(true);
  const RigidTransform guess{ExpQuaternion({0.08, -0.1, 0.09}) * kTrue.rotation,
                             kTrue.translation + Eigen::Vector3d(0.15, -0.1, 0.2)};
  const auto found =
      AlignMaps(a, SeenFrom(kTrue, a), RotationsAbout(guess, Eigen::Vector3d::Constant(0.09)), Anywhere);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->IsClear());
  EXPECT_LT(AngleBetween(found->T_a_b.rotation, kTrue.rotation), 0.01);
}

TEST(MapAlignment, SharesFallAwayFromThePlace) {
  const std::vector<MapPlane> a = Yard(true), b = SeenFrom(kTrue, a);
  const RigidTransform turned{ExpQuaternion({0.0, 0.0, 0.06}) * kTrue.rotation, kTrue.translation};
  EXPECT_GT(ShareOfPlanes(a, b, kTrue), 0.8);
  EXPECT_LT(ShareOfPlanes(a, b, turned), 0.5 * ShareOfPlanes(a, b, kTrue));
}

TEST(MapAlignment, TheGroundAloneIsNotClear) {
  const std::vector<MapPlane> a = Yard(false);
  const auto found = AlignMaps(a, SeenFrom(kTrue, a), AllRotations(), Anywhere);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->IsClear());
}

TEST(MapAlignment, TakesNoPlaceThatIsNotPlausible) {
  const std::vector<MapPlane> a = Yard(true);
  const auto elsewhere = [](const RigidTransform& T) {
    return AngleBetween(T.rotation, kTrue.rotation) > 0.2;
  };
  const auto found = AlignMaps(a, SeenFrom(kTrue, a), AllRotations(), elsewhere);
  EXPECT_TRUE(!found || !found->IsClear());
}

TEST(MapAlignment, HardlyAnyPlanesTellNothing) {
  std::vector<MapPlane> few = Yard(true);
  few.resize(10);
  EXPECT_FALSE(AlignMaps(few, few, AllRotations(), Anywhere));
}

}  // namespace
}  // namespace mlic::map_alignment_test
