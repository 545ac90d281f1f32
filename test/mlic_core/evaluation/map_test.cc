#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/evaluation/map_builder.h"
#include "mlic_core/evaluation/map_evaluation.h"
#include "mlic_core/evaluation/map_quality.h"
#include "mlic_core/evaluation/turned_entropy.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::map_test {
namespace {

// Points of two LiDARs on one wall x = 10, with noise along x; the second one's are `shift` farther.
std::vector<MapPoint> Wall(double noise, double shift) {
  Random random(11);
  std::vector<MapPoint> points;
  for (int i = 0; i < 8000; ++i) {
    MapPoint point;
    point.lidar = i % 2;
    point.plane = 0;
    const double x = 10.0 + noise * random.Normal() + (point.lidar == 1 ? shift : 0.0);
    const double y = random.Uniform(-2.0, 2.0), z = random.Uniform(0.0, 2.0);
    point.position = Eigen::Vector3d(x, y, z).cast<float>();
    points.push_back(point);
  }
  return points;
}

TEST(MapEntropy, MatchesTheFormulaOnAGaussianSlab) {
  // A disc of radius r in y and z has variance r^2 / 4 along each; x has the noise's variance.
  MapEntropyOptions options;
  const double noise = 0.02;
  const MapEntropy entropy = MeanMapEntropy(Wall(noise, 0.0), -1, options);
  const double disc = options.radius * options.radius / 4.0;
  const double expected =
      0.5 * std::log(std::pow(2.0 * M_PI * std::exp(1.0), 3) * disc * disc * noise * noise);
  EXPECT_NEAR(entropy.mean, expected, 0.15) << "the wall's edges shrink some discs";
  EXPECT_GT(entropy.queries_used, 7000u);
}

TEST(MapEntropy, GrowsWithMisalignmentButNotForOneLidarAlone) {
  MapEntropyOptions options;
  const std::vector<MapPoint> good = Wall(0.02, 0.0), bad = Wall(0.02, 0.05);
  EXPECT_GT(MeanMapEntropy(bad, -1, options).mean, MeanMapEntropy(good, -1, options).mean + 0.1);
  EXPECT_NEAR(MeanMapEntropy(bad, 1, options).mean, MeanMapEntropy(good, 1, options).mean, 0.01);
}

TEST(OverlapThickness, NoiseAndShiftAddUp) {
  const auto good = OverlapThicknesses(Wall(0.02, 0.0));
  ASSERT_EQ(good.size(), 1u);
  EXPECT_NEAR(good[0].thickness, 0.02, 0.001);
  EXPECT_LT(good[0].separation, 0.002);
  const auto bad = OverlapThicknesses(Wall(0.02, 0.08));
  EXPECT_NEAR(bad[0].thickness, std::hypot(0.02, 0.04), 0.001);
  EXPECT_NEAR(bad[0].separation, 0.08, 0.002);
}

TEST(OverlapThickness, PlanesThatOneLidarSeesDoNotCount) {
  std::vector<MapPoint> points = Wall(0.02, 0.0);
  for (MapPoint& point : points) point.plane = point.lidar;
  EXPECT_TRUE(OverlapThicknesses(points).empty());
}

TEST(AssignVoxelPlanes, FlatCellsOnly) {
  std::vector<MapPoint> points = Wall(0.01, 0.0);
  const std::size_t wall = points.size();
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    MapPoint point;
    point.position =
        Eigen::Vector3d(random.Uniform(20, 21), random.Uniform(0, 1), random.Uniform(0, 1)).cast<float>();
    points.push_back(point);
  }
  AssignVoxelPlanes(0.7, 0.05, &points);
  std::size_t on_wall = 0, in_box = 0;
  for (std::size_t i = 0; i < points.size(); ++i) (i < wall ? on_wall : in_box) += points[i].plane >= 0;
  EXPECT_GT(on_wall, wall * 95 / 100);
  EXPECT_LT(in_box, 100u);
}

TEST(EvaluateMap, FindsPlanesItselfAndNamesTheSensors) {
  std::vector<MapPoint> points = Wall(0.02, 0.03);
  for (MapPoint& point : points) {
    point.plane = -1;
    point.position.x() += 0.25f;  // away from a face of the voxels
  }
  CalibrationResult calibration;
  calibration.sensors.resize(3);
  calibration.sensors[0].name = "front";
  calibration.sensors[1].name = "left";
  calibration.sensors[2].name = "unseen";
  const MapEvaluation evaluation = EvaluateMap(points, calibration);
  ASSERT_EQ(evaluation.overlaps.size(), 1u);
  EXPECT_NEAR(evaluation.overlaps[0].separation, 0.03, 0.004);
  EXPECT_EQ(evaluation.of_sensor[2].queries_used, 0u);
  EXPECT_LT(evaluation.of_sensor[0].mean, evaluation.all.mean);
  EXPECT_NE(TableOf(evaluation, calibration).find("overlap front/left: thickness"), std::string::npos);
  EXPECT_NE(CsvOf(evaluation, calibration).find("\noverlap_separation,front/left,0.0"), std::string::npos);
  EXPECT_EQ(CsvOf(evaluation, calibration).find("unseen"), std::string::npos);
}

TEST(BuildMap, PutsPointsWhereTheyWere) {
  // The IMU moves along x and yaws; one point, seen from everywhere, must fall on one place.
  const Eigen::Vector3d landmark(5.0, 3.0, 1.0);
  CalibrationResult calibration;
  SensorResult sensor;
  sensor.name = "lidar";
  sensor.calibration = {{FromRollPitchYaw({0.1, 0.2, 0.3}), {0.5, -0.2, 0.1}}, 0.05};
  calibration.sensors = {SensorResult(), sensor};
  Drive drive;
  drive.epoch = 1700000000000000000;
  drive.lidars.resize(1);
  const auto pose_at = [](double t) {
    return RigidTransform{FromRollPitchYaw({0, 0, 0.5 * t}), {2.0 * t, 0, 0}};
  };
  std::vector<StampedPose> trajectory;
  for (int i = 0; i <= 2000; ++i)
    trajectory.push_back({TimeFrom(drive.epoch, 0.001 * i), pose_at(0.001 * i)});
  for (int i = 0; i < 20; ++i) {
    LidarScan scan;
    scan.time = 0.1 * i - 0.05;
    for (int k = 0; k < 5; ++k) {
      const double t_imu = scan.time + 0.01 * k + 0.05;
      LidarPoint point;
      point.time = static_cast<float>(0.01 * k);
      const RigidTransform T_map_lidar = pose_at(t_imu) * sensor.calibration.T_imu_sensor;
      point.position = (T_map_lidar.Inverse() * landmark).cast<float>();
      scan.points.push_back(point);
    }
    drive.lidars[0].scans.push_back(scan);
  }
  const std::vector<MapPoint> map = BuildMap(drive, {"lidar"}, trajectory, calibration, 1);
  EXPECT_EQ(map.size(), 100u);
  for (const MapPoint& point : map) {
    EXPECT_LT((point.position.cast<double>() - landmark).norm(), 1e-5);
    EXPECT_EQ(point.lidar, 1);
  }
  EXPECT_EQ(BuildMap(drive, {"lidar"}, trajectory, calibration, 4).size(), 25u);
  EXPECT_TRUE(BuildMap(drive, {"other"}, trajectory, calibration, 1).empty());
}

// A LiDAR that turns about the vertical between two walls and a floor, seen again from every heading.
TEST(TurnedEntropy, IsLeastAsCalibrated) {
  Drive drive;
  drive.epoch = 1700000000000000000;
  LidarRecording& lidar = drive.lidars.emplace_back();
  CalibrationResult calibration;
  SensorResult sensor;
  sensor.name = "lidar";
  sensor.type = SensorResult::Type::kLidar;
  sensor.calibration.T_imu_sensor = {ExpQuaternion({0.2, -0.1, 0.4}), {0.5, 0.0, 0.1}};
  calibration.sensors = {sensor};
  std::vector<StampedPose> trajectory;
  Random random(2);
  for (int k = 0; k < 40; ++k) {
    const double t = 0.1 * k;
    const RigidTransform T_map_imu{ExpQuaternion({0.2 * std::sin(t), 0.2 * std::cos(t), 0.6 * t}),
                                   {0.5 * t, 0.0, 0.0}};
    trajectory.push_back({TimeFrom(drive.epoch, t), T_map_imu});
    LidarScan& scan = lidar.scans.emplace_back();
    scan.time = t;
    const RigidTransform T_lidar_map = (T_map_imu * sensor.calibration.T_imu_sensor).Inverse();
    for (int i = 0; i < 150; ++i) {
      Eigen::Vector3d x(4.0 * random.Normal(), 4.0 * random.Normal(), 2.0 * random.Normal());
      x[i % 3] = i % 3 == 2 ? -2.0 : 5.0;
      LidarPoint point{};
      point.position =
          (T_lidar_map * (x + 0.002 * random.Normal() * Eigen::Vector3d::Unit(i % 3))).cast<float>();
      scan.points.push_back(point);
    }
  }
  const std::vector<TurnedEntropy> found =
      EntropyOfTurnedLidars(drive, {"lidar"}, trajectory, calibration, 1);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].degrees, 0.0);
  EXPECT_EQ(found[0].mean, found[0].least);
  EXPECT_LT(found[0].mean, found[1].least);
  EXPECT_LT(found[1].mean, found[2].mean - 0.1);
  EXPECT_EQ(CsvOf(found).substr(0, 25), "lidar,degrees,mean,least\n");
}

}  // namespace
}  // namespace mlic::map_test
