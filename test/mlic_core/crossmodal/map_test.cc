#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "mlic_core/common/random.h"
#include "mlic_core/crossmodal/projection_table.h"
#include "mlic_core/crossmodal/renderer.h"

namespace mlic::map_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

CameraIntrinsics Camera(CameraModel model, double fov_deg) {
  CameraIntrinsics intrinsics = IntrinsicsFromFieldOfView(model, 640, 480, fov_deg);
  intrinsics.parameters[2] += 5.3;
  if (model != CameraModel::kDoubleSphere) intrinsics.parameters[4] = -0.03;
  return intrinsics;
}

TEST(ProjectionTable, AgreesWithTheModelsAllOverTheImage) {
  const CameraIntrinsics cameras[] = {
      Camera(CameraModel::kPlumbBob, 120.0), Camera(CameraModel::kRationalPolynomial, 90.0),
      Camera(CameraModel::kEquidistant, 190.0), Camera(CameraModel::kDoubleSphere, 160.0)};
  Random random(3);
  for (const CameraIntrinsics& camera : cameras) {
    const ProjectionTable table(camera);
    double worst = 0.0, worst_slope = 0.0;
    int seen = 0;
    for (int i = 0; i < 20000; ++i) {
      const Eigen::Vector2d pixel(random.Uniform(0.0, 639.0), random.Uniform(0.0, 479.0));
      Vector3d bearing;
      Eigen::Vector2d exact;
      if (!Unproject(camera, pixel, &bearing) || !Project(camera, bearing, &exact)) continue;
      const double range = random.Uniform(0.5, 50.0);
      ProjectionTable::Pixel out;
      if (!table.Project((range * bearing).cast<float>(), static_cast<float>(range), &out)) continue;
      ++seen;
      worst = std::max(worst, (Eigen::Vector2d(out.u, out.v) - exact).norm());
      // The derivative along q_x, by way of a bearing that is a little off.
      const double qx = out.qx + 1e-4, qy = out.qy;
      Eigen::Vector2d moved;
      if (Project(camera, {2.0 * qx, 2.0 * qy, 1.0 - qx * qx - qy * qy}, &moved)) {
        worst_slope =
            std::max(worst_slope, std::abs((moved - exact).x() / 1e-4 - out.u_x) / std::abs(out.u_x));
      }
    }
    EXPECT_GT(seen, 14000);
    EXPECT_LT(worst, 0.03);
    EXPECT_LT(worst_slope, 0.05);
  }
}

// Returns of a LiDAR that looks at a surface. brightness: of the surface at a place.
struct Beam {
  Vector3d origin, target;
  Vector3d normal;
  double brightness;
};

MapReturn ReturnOf(const Beam& beam, int lidar, double time, double noise, Random& random) {
  const Vector3d ray = beam.target - beam.origin;
  const double range = ray.norm() + noise * random.Normal();
  const Vector3d direction = ray.normalized();
  MapReturn r;
  r.beam = (range * direction).cast<float>();
  r.position = (beam.origin + range * direction).cast<float>();
  r.lidar = static_cast<std::uint16_t>(lidar);
  r.time = time;
  const double cosine = std::abs(direction.dot(beam.normal));
  const double light = beam.brightness * cosine * (1.0 + 0.03 * random.Normal());
  // Two makes: another falloff, another scale, and the second one writes a power of the light.
  r.intensity = static_cast<float>(lidar == 0 ? 200.0 * light / (1.0 + range * range / 400.0)
                                              : 3000.0 * std::pow(light, 0.6) / (1.0 + range / 10.0));
  return r;
}

double Chequers(double x, double y) {
  return (static_cast<int>(std::floor(x)) + static_cast<int>(std::floor(y))) % 2 ? 0.2 : 0.8;
}

// A chequered floor, x < 1 seen by the first LiDAR, x > -1 by the second.
std::vector<MapReturn> Floor() {
  Random random(5);
  std::vector<MapReturn> returns;
  for (int lidar = 0; lidar < 2; ++lidar) {
    for (int i = 0; i < 60000; ++i) {
      const Vector3d target(lidar == 0 ? random.Uniform(-8.0, 1.0) : random.Uniform(-1.0, 8.0),
                            random.Uniform(-4.0, 4.0), 0.0);
      const Vector3d origin(lidar == 0 ? random.Uniform(-6.0, 0.0) : random.Uniform(0.0, 6.0),
                            random.Uniform(-3.0, 3.0), 1.8);
      returns.push_back(ReturnOf({origin, target, Vector3d::UnitZ(), Chequers(target.x(), target.y())}, lidar,
                                 1e-4 * i, 0.02, random));
    }
  }
  return returns;
}

TEST(IntensityMap, HasNoSeamBetweenLidarsOfDifferentMakes) {
  const IntensityMap map = BuildIntensityMap(Floor(), {});
  ASSERT_GT(map.points.size(), 110000u);
  ASSERT_EQ(map.points.size(), map.origins.size());
  double sum[2][2] = {}, count[2][2] = {}, squares[2][2] = {}, height = 0.0;
  for (std::size_t k = 0; k < map.points.size(); ++k) {
    const SurfacePoint& p = map.points[k];
    height += p.position.z() * p.position.z() / map.points.size();
    EXPECT_GE(p.intensity, 0.0f);
    EXPECT_LE(p.intensity, 1.0f);
    const int bright = Chequers(p.position.x(), p.position.y()) > 0.5, lidar = map.origins[k].lidar;
    sum[bright][lidar] += p.intensity;
    squares[bright][lidar] += p.intensity * p.intensity;
    count[bright][lidar] += 1.0;
  }
  double mean[2][2];
  for (int bright = 0; bright < 2; ++bright) {
    for (int lidar = 0; lidar < 2; ++lidar) {
      mean[bright][lidar] = sum[bright][lidar] / count[bright][lidar];
      const double variance =
          squares[bright][lidar] / count[bright][lidar] - mean[bright][lidar] * mean[bright][lidar];
      // Range and incidence are compensated: what is left is noise, and points at the chequers' borders.
      EXPECT_LT(std::sqrt(variance), 0.16 * mean[bright][lidar]) << bright << lidar;
    }
    EXPECT_NEAR(mean[bright][1] / mean[bright][0], 1.0, 0.04) << "the seam at brightness " << bright;
  }
  // The square root of 4.
  EXPECT_NEAR(mean[1][0] / mean[0][0], 2.0, 0.15);
  EXPECT_LT(std::sqrt(height), 0.01) << "range noise of 0.02 m should be reduced";
}

TEST(IntensityMap, IsTheSameForAnyNumberOfThreads) {
  const std::vector<MapReturn> returns = Floor();
  const IntensityMap many = BuildIntensityMap(returns, {});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const IntensityMap alone = BuildIntensityMap(returns, {});
  ASSERT_EQ(many.points.size(), alone.points.size());
  EXPECT_EQ(std::memcmp(many.points.data(), alone.points.data(), many.points.size() * sizeof(SurfacePoint)),
            0);
}

TEST(IntensityMap, LidarsWithoutIntensityGiveAnEvenMap) {
  std::vector<MapReturn> returns = Floor();
  for (MapReturn& r : returns) r.intensity = 0.0f;
  for (const SurfacePoint& p : BuildIntensityMap(returns, {}).points) ASSERT_EQ(p.intensity, 0.5f);
  EXPECT_TRUE(BuildIntensityMap({}, {}).points.empty());
}

// A wall at x = 12 m, seen by a LiDAR at the origin for ten seconds; between seconds 4 and 5 a box stands in
// the way.
std::vector<MapReturn> WallBehindAVisitor() {
  Random random(7);
  std::vector<MapReturn> returns;
  for (int i = 0; i < 200000; ++i) {
    const double time = 5e-5 * i;
    const Vector3d direction =
        Vector3d(1.0, random.Uniform(-0.5, 0.5), random.Uniform(-0.2, 0.2)).normalized();
    double range = 12.0 / direction.x();
    const Vector3d at_six = direction * (6.0 / direction.x());
    if (time > 4.0 && time < 5.0 && std::abs(at_six.y()) < 0.6 && std::abs(at_six.z()) < 0.9)
      range = at_six.norm();
    returns.push_back(
        ReturnOf({Vector3d::Zero(), range * direction, Vector3d::UnitX(), 0.5}, 0, time, 0.02, random));
  }
  return returns;
}

TEST(IntensityMap, LeavesOutWhatMoved) {
  const auto visitors = [](const IntensityMap& map) {
    return std::count_if(map.points.begin(), map.points.end(),
                         [](const SurfacePoint& p) { return p.position.x() < 9.0f; });
  };
  const std::vector<MapReturn> returns = WallBehindAVisitor();
  IntensityMapOptions keep;
  keep.remove_moving = false;
  const IntensityMap everything = BuildIntensityMap(returns, keep), still = BuildIntensityMap(returns, {});
  EXPECT_GT(visitors(everything), 2000);
  EXPECT_LT(visitors(still), visitors(everything) / 20);
  EXPECT_GT(still.points.size(), everything.points.size() - visitors(everything) * 11 / 10);
}

// Off the faces of the map's voxels.
constexpr double kWall = 12.04;
double FromWindow(double y) { return std::abs(y - 0.06 - 2.0 * std::round(0.5 * (y - 0.06))); }

// A facade with windows of 1 m every 2 m, 14 cm deep, seen from the right and the left. Their sides send
// nothing back.
std::vector<MapReturn> Facade() {
  Random random(11);
  std::vector<MapReturn> returns;
  for (int i = 0; i < 150000; ++i) {
    const Vector3d origin(0.0, random.Uniform(-4.0, 4.0), 0.0);
    const Vector3d target(kWall, random.Uniform(-5.0, 5.0), random.Uniform(-1.0, 1.0));
    const Vector3d behind = origin + (kWall + 0.14) / kWall * (target - origin);
    const bool glass = FromWindow(target.y()) < 0.5;
    if (glass && FromWindow(behind.y()) > 0.5) continue;
    returns.push_back(ReturnOf({origin, glass ? behind : target, Vector3d::UnitX(), glass ? 0.15 : 0.6}, 0,
                               1e-4 * i, 0.02, random));
  }
  return returns;
}

// Where a voxel holds the wall and the glass, its points are those of the two beside them.
TEST(IntensityMap, KnowsSurfacesUpToTheirEdges) {
  const IntensityMap map = BuildIntensityMap(Facade(), {});
  double near = 0.0, planes = 0.0, sum[2] = {}, count[2] = {}, all[2] = {}, all_count[2] = {};
  for (const SurfacePoint& p : map.points) {
    const int glass = p.position.x() > kWall + 0.07;
    all[glass] += p.intensity, all_count[glass] += 1.0;
    if (std::abs(FromWindow(p.position.y()) - 0.5) > 0.06) continue;
    near += 1.0, planes += p.normal.isZero() ? 0.0 : 1.0;
    sum[glass] += p.intensity, count[glass] += 1.0;
  }
  ASSERT_GT(near, 10000.0);
  EXPECT_GT(planes / near, 0.9);
  for (int glass = 0; glass < 2; ++glass) {
    EXPECT_NEAR(sum[glass] / count[glass], all[glass] / all_count[glass],
                0.03 * all[glass] / all_count[glass])
        << "a frame around windows, seen at " << (glass ? "the glass" : "the wall");
  }
}

TEST(RenderedMap, ShowsNoFarPointsBetweenNearOnes) {
  // A board at 4 m with points every 4 cm before a wall at 8 m with points every 2 cm.
  Random random(9);
  std::vector<MapReturn> returns;
  const auto add = [&](double z, double half, int count, double brightness) {
    for (int i = 0; i < count; ++i) {
      const Vector3d target(random.Uniform(-half, half), random.Uniform(-half, half), z);
      returns.push_back(ReturnOf({Vector3d::Zero(), target, Vector3d::UnitZ(), brightness}, 0,
                                 10.0 * i / count, 0.01, random));
    }
  };
  add(4.0, 1.0, 2500, 0.2);
  add(8.0, 5.0, 250000, 0.8);
  std::stable_sort(returns.begin(), returns.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  IntensityMapOptions options;
  options.remove_moving = false;  // the LiDAR sees through the board
  const IntensityMap map = BuildIntensityMap(returns, options);
  const CameraIntrinsics camera = Camera(CameraModel::kEquidistant, 100.0);
  // To one side of the LiDAR: the wall behind the board is in the map in part.
  const ViewPose pose = FixedPose({Eigen::Quaterniond::Identity(), Vector3d(1.2, 0.1, 0.0)});
  const RenderedView view = ViewRenderer(map, camera, {}).Render(pose);
  int board = 0, through = 0, wall = 0, unseen = 0;
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      Vector3d bearing;
      if (!Unproject(camera, Eigen::Vector2d(column, row), &bearing)) continue;
      const Vector3d ray = bearing / bearing.z();
      const Vector3d at_board = Vector3d(1.2, 0.1, 0.0) + 4.0 * ray,
                     at_wall = Vector3d(1.2, 0.1, 0.0) + 8.0 * ray;
      if (std::max(std::abs(at_wall.x()), std::abs(at_wall.y())) > 4.8) continue;
      const double beside = std::max(std::abs(at_board.x()), std::abs(at_board.y()));
      const float depth = view.depth.at<float>(row, column);
      if (beside < 0.95) {
        ++board;
        if (depth > 6.0f) ++through;
        if (depth == 0.0f) ++unseen;
      } else if (beside > 1.1 && depth > 6.0f) {
        ++wall;
        Vector3d place;
        ASSERT_TRUE(SurfaceAt(view, camera, pose, Eigen::Vector2d(column, row), &place));
        ASSERT_NEAR(place.z(), 8.0, 0.05);
      }
    }
  }
  EXPECT_GT(board, 10000);
  EXPECT_GT(wall, 60000);
  EXPECT_LT(through, board / 100);
  EXPECT_LT(unseen, board / 50);
}

}  // namespace
}  // namespace mlic::map_test
