#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/geometry/so3.h"
#include "mlic_sim/hall.h"
#include "mlic_sim/lidar_scanner.h"

namespace mlic::sim::lidar_test {
namespace {

using Eigen::Vector3d;

// Closed by a big wall in the plane x = 10, nothing else.
World WallWorld(double half_size = 100.0) {
  Mesh mesh;
  mesh.AddQuad({10, -half_size, -half_size}, {10, half_size, -half_size}, {10, half_size, half_size},
               {10, -half_size, half_size}, Material::kWindowFrame);
  return World(std::move(mesh));
}

LidarModel SmallRaster() {
  LidarModel model;
  model.kind = ScanPatternKind::kRaster;
  model.fov_deg[0] = 60.0;
  model.columns = 120;
  model.rows = 40;
  return model;
}

std::unique_ptr<Trajectory> Parked() { return MakeTrajectory(Scenario::kStatic, 1, 1.0, {}); }

// The pose that puts a LiDAR at the map's origin, level and looking along x.
RigidTransform AtOrigin(const Trajectory& trajectory) { return trajectory.PoseAt(0.0).Inverse(); }

TEST(ScanPattern, SpinningCoversTheTurnInOrderOfTime) {
  LidarModel model;
  model.rings = 16;
  model.azimuth_steps = 900;
  const std::vector<Firing> firings = MakeScanPattern(model, 0);
  ASSERT_EQ(firings.size(), 16u * 900u);
  for (std::size_t i = 1; i < firings.size(); ++i) EXPECT_GE(firings[i].time, firings[i - 1].time);
  EXPECT_LT(firings.back().time, 0.1);
  // Clockwise from x: a quarter turn later it looks along -y.
  const Vector3d quarter = firings[16 * 225].direction;
  EXPECT_NEAR(std::atan2(quarter.y(), quarter.x()), -M_PI / 2, 1e-9);
  EXPECT_NEAR(std::asin(firings[0].direction.z()) * 180 / M_PI, -20.0, 1e-9);
  EXPECT_NEAR(std::asin(firings[15].direction.z()) * 180 / M_PI, 20.0, 1e-9);
}

TEST(ScanPattern, RasterAndRosetteFillTheirFieldsOfView) {
  LidarModel raster;
  raster.kind = ScanPatternKind::kRaster;
  double widest = 0.0, highest = 0.0;
  for (const Firing& f : MakeScanPattern(raster, 0)) {
    widest = std::max(widest, std::abs(std::atan2(f.direction.y(), f.direction.x())) * 180 / M_PI);
    highest = std::max(highest, std::abs(std::asin(f.direction.z())) * 180 / M_PI);
  }
  EXPECT_NEAR(widest, 60.0, 0.5);
  EXPECT_NEAR(highest, 12.5, 0.5);
  LidarModel rosette;
  rosette.kind = ScanPatternKind::kRosette;
  const std::vector<Firing> first = MakeScanPattern(rosette, 0), second = MakeScanPattern(rosette, 1);
  double farthest = 0.0, change = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    farthest = std::max(farthest, std::acos(first[i].direction.x()) * 180 / M_PI);
    change = std::max(change, (first[i].direction - second[i].direction).norm());
  }
  EXPECT_NEAR(farthest, 35.0, 0.2);
  EXPECT_GT(change, 0.1);
}

TEST(Scanner, NoiseFreePointsLieOnTheSurfacesWhileTheRigMoves) {
  const World world = WallWorld();
  const auto trajectory = MakeTrajectory(Scenario::kHandheld, 2, 10.0, {});
  const RigidTransform T_imu_lidar{FromRollPitchYaw({0.1, 0.2, 0.3}), Vector3d(0.1, 0.2, 0.3)};
  LidarModel model;
  const std::vector<SimulatedPoint> points =
      CastScan(world, *trajectory, T_imu_lidar, model, MakeScanPattern(model, 0), 4.0, std::nullopt);
  int returns = 0;
  for (const SimulatedPoint& p : points) {
    if (!p.returned) continue;
    ++returns;
    const Vector3d in_map = trajectory->PoseAt(4.0 + p.time) * (T_imu_lidar * p.position.cast<double>());
    // Points are floats: 1e-7 of the range.
    EXPECT_NEAR(in_map.x(), 10.0, 2e-7 * p.position.norm() + 1e-7);
  }
  EXPECT_GT(returns, 1000);
}

// Distance of a point to a triangle's plane if it projects near the triangle, else infinite.
double DistanceToTriangle(const Mesh& mesh, const Triangle& triangle, const Vector3d& p) {
  Vector3d v[3];
  for (int i = 0; i < 3; ++i) v[i] = mesh.vertices()[triangle.vertices[i]].cast<double>();
  const Vector3d normal = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
  for (int i = 0; i < 3; ++i) {
    const Vector3d edge = v[(i + 1) % 3] - v[i];
    if (normal.cross(edge).normalized().dot(p - v[i]) < -1e-4) return std::numeric_limits<double>::infinity();
  }
  return std::abs(normal.dot(p - v[0]));
}

TEST(Scanner, NoiseFreePointsLieOnTheHall) {
  const auto hall = MakeHall();
  const auto trajectory = MakeTrajectory(Scenario::kHandheld, 3, 10.0, {});
  LidarModel model;
  model.azimuth_steps = 40;
  int returns = 0;
  for (const SimulatedPoint& p :
       CastScan(*hall, *trajectory, {}, model, MakeScanPattern(model, 0), 1.0, std::nullopt)) {
    if (!p.returned) continue;
    ++returns;
    const Vector3d in_map = trajectory->PoseAt(1.0 + p.time) * p.position.cast<double>();
    double nearest = std::numeric_limits<double>::infinity();
    for (const Triangle& t : hall->mesh().triangles()) {
      nearest = std::min(nearest, DistanceToTriangle(hall->mesh(), t, in_map));
    }
    EXPECT_LT(nearest, 5e-6);
  }
  EXPECT_GT(returns, 1000);
}

// Every other material's contrast turns over, what the beams hit stays.
TEST(Scanner, HalfOfTheInfraredCanBeInverted) {
  const Vector3d p(0.31, 0.17, 1.2), up = Vector3d::UnitZ();
  int inverted = 0;
  for (const Material material : {Material::kHallFloor, Material::kWood, Material::kDoor, Material::kMetal}) {
    const float related = NearInfraredOf(material, p, up, 0, InfraredLook::kRelated);
    const float other = NearInfraredOf(material, p, up, 0, InfraredLook::kInvertedHalf);
    if (other == related) continue;
    EXPECT_FLOAT_EQ(other, 1.0f - related);
    ++inverted;
  }
  EXPECT_EQ(inverted, 2);
  const auto trajectory = MakeTrajectory(Scenario::kHandheld, 3, 10.0, {});
  LidarModel model;
  model.azimuth_steps = 40;
  const std::vector<Firing> firings = MakeScanPattern(model, 0);
  const auto related = CastScan(*MakeHall(), *trajectory, {}, model, firings, 1.0, std::nullopt);
  const auto mixed =
      CastScan(*MakeHall(InfraredLook::kInvertedHalf), *trajectory, {}, model, firings, 1.0, std::nullopt);
  int differ = 0, returned = 0;
  for (std::size_t i = 0; i < related.size(); ++i) {
    if (!related[i].returned) continue;
    ++returned;
    EXPECT_EQ(related[i].position, mixed[i].position);
    differ += std::abs(related[i].intensity - mixed[i].intensity) > 1.0f;
  }
  EXPECT_GT(differ, returned / 5);
  EXPECT_LT(differ, 4 * returned / 5);
}

TEST(Scanner, RangeNoiseHasTheStatedSigma) {
  const World world = WallWorld();
  const auto trajectory = Parked();
  LidarModel model = SmallRaster();
  model.range_noise = 0.03;
  const std::vector<Firing> firings = MakeScanPattern(model, 0);
  double sum = 0.0, square = 0.0, count = 0.0;
  for (std::uint64_t scan = 0; scan < 5; ++scan) {
    const auto points =
        CastScan(world, *trajectory, AtOrigin(*trajectory), model, firings, 0.0, Random(scan));
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!points[i].returned) continue;
      const double error = points[i].position.norm() - 10.0 / firings[i].direction.x();
      sum += error, square += error * error, count += 1.0;
    }
  }
  EXPECT_GT(count, 20000);
  EXPECT_NEAR(sum / count, 0.0, 5.0 * 0.03 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(square / count), 0.03, 0.03 * 0.03);
}

TEST(Scanner, EdgesGiveMixedPixelsOnlyWithNoise) {
  // A plate 0.8 m in front of the wall.
  Mesh mesh;
  mesh.AddQuad({10, -50, -50}, {10, 50, -50}, {10, 50, 50}, {10, -50, 50}, Material::kWindowFrame);
  mesh.AddQuad({9.2, -0.5, -50}, {9.2, 0.5, -50}, {9.2, 0.5, 50}, {9.2, -0.5, 50}, Material::kWindowFrame);
  const World world(std::move(mesh));
  const auto trajectory = Parked();
  LidarModel model = SmallRaster();
  model.columns = 2000;
  model.range_noise = 0.0;
  const auto between = [&](const std::optional<Random>& noise) {
    int mixed = 0;
    for (const SimulatedPoint& p :
         CastScan(world, *trajectory, AtOrigin(*trajectory), model, MakeScanPattern(model, 0), 0.0, noise)) {
      mixed += p.returned && p.position.x() > 9.25 && p.position.x() < 9.95;
    }
    return mixed;
  };
  EXPECT_EQ(between(std::nullopt), 0);
  EXPECT_GT(between(Random(7)), 10);
  EXPECT_LT(between(Random(7)), 2000 * 40 / 50);
}

TEST(Scanner, FarAndDarkBeamsDropOut) {
  const World world = WallWorld();
  const auto trajectory = Parked();
  LidarModel model = SmallRaster();
  const auto share = [&](double range_at_10_percent) {
    model.range_at_10_percent = range_at_10_percent;
    const auto points =
        CastScan(world, *trajectory, AtOrigin(*trajectory), model, MakeScanPattern(model, 0), 0.0, Random(3));
    const auto returned =
        std::count_if(points.begin(), points.end(), [](const auto& p) { return p.returned; });
    return static_cast<double>(returned) / static_cast<double>(points.size());
  };
  EXPECT_GT(share(100.0), 0.99);
  EXPECT_LT(share(2.0), 0.1);
}

// Mean of the range errors on the wall by ring, and the share of beams that came back.
struct WallErrors {
  std::vector<double> mean;
  double returned = 0.0;
  std::vector<SimulatedPoint> points;
};
WallErrors CastAtWall(const LidarModel& model, std::optional<Random> noise) {
  const World world = WallWorld();
  const auto trajectory = Parked();
  const std::vector<Firing> firings = MakeScanPattern(model, 0);
  WallErrors errors;
  errors.points = CastScan(world, *trajectory, AtOrigin(*trajectory), model, firings, 0.0, noise);
  std::vector<double> sum(static_cast<std::size_t>(model.rows)), count(sum.size());
  for (std::size_t i = 0; i < firings.size(); ++i) {
    const SimulatedPoint& p = errors.points[i];
    if (!p.returned) continue;
    errors.returned += 1.0 / static_cast<double>(firings.size());
    sum[p.ring] += p.position.norm() - 10.0 / firings[i].direction.x();
    count[p.ring] += 1.0;
  }
  for (std::size_t r = 0; r < sum.size(); ++r) errors.mean.push_back(sum[r] / count[r]);
  return errors;
}

TEST(Scanner, RingBiasShiftsItsRingOnly) {
  LidarModel model = SmallRaster();
  model.ring_bias.assign(static_cast<std::size_t>(model.rows), 0.0);
  model.ring_bias[7] = 0.03;
  const WallErrors errors = CastAtWall(model, std::nullopt);
  for (std::size_t r = 0; r < errors.mean.size(); ++r) EXPECT_NEAR(errors.mean[r], r == 7 ? 0.03 : 0.0, 1e-5);
}

// Window frames reflect about 0.75 of the LiDAR's light: at grazing incidence less comes back, and later.
TEST(Scanner, RangeWalkGrowsAsEchoesGetWeaker) {
  LidarModel model = SmallRaster();
  model.range_walk = 0.05;
  model.fov_deg[0] = 160.0;
  const WallErrors with = CastAtWall(model, std::nullopt);
  model.range_walk = 0.0;
  const WallErrors without = CastAtWall(model, std::nullopt);
  const std::vector<Firing> firings = MakeScanPattern(model, 0);
  int tested = 0;
  for (std::size_t i = 0; i < firings.size(); ++i) {
    if (!with.points[i].returned) continue;
    const double cosine = firings[i].direction.x();
    const double walk = with.points[i].position.norm() - without.points[i].position.norm();
    // The reflectance alone spreads by 20 percent: 0.05 log10(1.2) = 4 mm.
    EXPECT_NEAR(walk, -0.05 * std::log10(cosine * 0.75 / 0.5), 0.005);
    ++tested;
  }
  EXPECT_GT(tested, 3000);
}

TEST(Scanner, LostPacketsLeaveGapsAndNothingElse) {
  LidarModel model = SmallRaster();
  const WallErrors all = CastAtWall(model, Random(5));
  model.packet_loss = 0.3;
  const WallErrors some = CastAtWall(model, Random(5));
  EXPECT_NEAR(some.returned / all.returned, 0.7, 0.12);
  int changes = 0;
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    if (some.points[i].returned) {
      EXPECT_EQ(some.points[i].position, all.points[i].position);
    }
    if (i > 0 && all.points[i].returned && all.points[i - 1].returned) {
      changes += some.points[i].returned != some.points[i - 1].returned;
    }
  }
  EXPECT_LT(changes, 100);  // whole packets, not beams here and there
}

TEST(Scanner, RainSendsBackItsShareOfBeamsFromInFrontOfTheWall) {
  LidarModel model = SmallRaster();
  model.range_at_10_percent = 1000.0;  // drops are dark, and seen all the same
  model.rain = 0.01;
  const WallErrors errors = CastAtWall(model, Random(5));
  double drops = 0.0, returned = 0.0;
  for (const SimulatedPoint& p : errors.points) {
    returned += p.returned;
    drops += p.returned && p.position.x() < 9.8f;
  }
  // Ways of 10 to 12 m: 10 percent.
  EXPECT_NEAR(drops / returned, 0.1, 0.02);
  EXPECT_LT(drops, returned);
}

TEST(Scanner, IntensityFallsWithRangeAndIncidence) {
  EXPECT_GT(IntensityOf(0.5, 1.0, 10.0), IntensityOf(0.5, 0.5, 10.0));
  EXPECT_GT(IntensityOf(0.5, 1.0, 10.0), IntensityOf(0.5, 1.0, 40.0));
  EXPECT_GT(IntensityOf(0.5, 1.0, 10.0), IntensityOf(0.2, 1.0, 10.0));
  EXPECT_LE(IntensityOf(1.0, 1.0, 0.0), 255.0);
}

TEST(Material, NearInfraredIsRelatedToTheVisibleButNotTheSame) {
  // Over the yard's ground, paint and asphalt differ in both, and the ratio is not constant.
  Random random(1);
  double sum_v = 0, sum_n = 0, vv = 0, nn = 0, vn = 0;
  constexpr int kCount = 4000;
  for (int i = 0; i < kCount; ++i) {
    const Vector3d p(random.Uniform(-30, 30), random.Uniform(-20, 20), 0.0);
    const Reflectance r = ReflectanceOf(Material::kYardGround, p, Vector3d::UnitZ(), 0);
    const double v = r.albedo.mean(), n = r.near_infrared;
    EXPECT_GE(n, 0.0);
    EXPECT_LE(n, 1.0);
    sum_v += v, sum_n += n, vv += v * v, nn += n * n, vn += v * n;
  }
  const double covariance = vn - sum_v * sum_n / kCount;
  const double correlation =
      covariance / std::sqrt((vv - sum_v * sum_v / kCount) * (nn - sum_n * sum_n / kCount));
  EXPECT_GT(correlation, 0.6);
  EXPECT_LT(correlation, 0.999);
}

}  // namespace
}  // namespace mlic::sim::lidar_test
