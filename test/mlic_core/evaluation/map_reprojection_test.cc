#include "mlic_core/evaluation/map_reprojection.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::map_reprojection_test {
namespace {

constexpr TimeNs kEpoch = 1700000000000000000;
constexpr double kFocalLength = 400.0;  // px

RigidTransform PoseAt(double t) { return {FromRollPitchYaw({0.0, 0.0, 0.1 * t}), {0.5 * t, 0.3 * t, 0.0}}; }

std::vector<StampedPose> Path() {
  std::vector<StampedPose> path;
  for (int k = -50; k <= 200; ++k) path.push_back({TimeFrom(kEpoch, 0.01 * k), PoseAt(0.01 * k)});
  return path;
}

// Two LiDARs and a pinhole that looks ahead along x.
CalibrationResult Truth() {
  CalibrationResult truth;
  truth.sensors.resize(3);
  truth.sensors[0].name = "top";
  truth.sensors[0].calibration = {{FromRollPitchYaw({0.1, 0.2, 0.3}), {0.2, 0.1, 0.5}}, 0.02};
  truth.sensors[1].name = "side";
  truth.sensors[1].calibration = {{FromRollPitchYaw({-0.2, 0.0, 1.3}), {-0.2, 0.4, 0.1}}, -0.01};
  SensorResult& camera = truth.sensors[2];
  camera.name = "camera";
  camera.type = SensorResult::Type::kCamera;
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  camera.calibration = {{Eigen::Quaterniond(R), {0.3, 0.0, 0.2}}, 0.005};
  camera.intrinsics = CameraIntrinsics{
      CameraModel::kPlumbBob, 640, 480, {kFocalLength, kFocalLength, 320, 240, 0, 0, 0, 0, 0}};
  return truth;
}

// Points 10 m ahead of the camera, half of each LiDAR, at their places in a photo at 0.5 s.
MapSightings SightingsOf(const CalibrationResult& truth, std::size_t count) {
  Random random(4);
  MapSightings sightings{{"top", "side"}, {"camera"}, {}};
  LandmarkSet& set = sightings.matches;
  set.begin.push_back(0);
  const SensorCalibration& camera = truth.sensors[2].calibration;
  const RigidTransform T_map_camera = PoseAt(0.5 + camera.time_offset) * camera.T_imu_sensor;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d p_in_camera(random.Uniform(-3.0, 3.0), random.Uniform(-2.0, 2.0), 10.0);
    const int lidar = static_cast<int>(i % 2);
    const double time = random.Uniform(0.0, 1.0);
    const SensorCalibration& of_lidar = truth.sensors[static_cast<std::size_t>(lidar)].calibration;
    const RigidTransform T_map_lidar = PoseAt(time + of_lidar.time_offset) * of_lidar.T_imu_sensor;
    LidarPointObservation point;
    point.lidar = lidar;
    point.time = time;
    point.position = T_map_lidar.Inverse() * (T_map_camera * p_in_camera);
    const Eigen::Vector2d pixel = kFocalLength * p_in_camera.head<2>() / 10.0 + Eigen::Vector2d(320.0, 240.0);
    const LandmarkObservation seen{0, 1.0f, 0.5, pixel, Eigen::Matrix2f::Identity()};
    set.points.push_back({T_map_camera * p_in_camera, T_map_camera.translation});
    set.lidar_points.push_back(point);
    set.observations.push_back(seen);
    set.begin.push_back(set.observations.size());
  }
  return sightings;
}

TEST(MapReprojection, IsNothingAtTheTruth) {
  const CalibrationResult truth = Truth();
  const auto errors = MeasureReprojection(SightingsOf(truth, 200), truth, Path(), kEpoch);
  ASSERT_EQ(errors.size(), 3u);  // all LiDARs, then each
  EXPECT_EQ(errors[0].lidar, "");
  EXPECT_EQ(errors[0].matches, 200u);
  EXPECT_EQ(errors[2].lidar, "side");
  for (const ReprojectionStatistics& error : errors) EXPECT_LT(error.rms, 0.01);
}

// A LiDAR that is turned about the line of sight's normal moves its points by the angle times the focal
// length.
TEST(MapReprojection, TellsWhichPairIsOff) {
  const CalibrationResult truth = Truth();
  CalibrationResult turned = truth;
  RigidTransform& T = turned.sensors[1].calibration.T_imu_sensor;
  T.rotation = ExpQuaternion(Eigen::Vector3d(0.0, 0.0, 0.005)) * T.rotation;
  const auto errors = MeasureReprojection(SightingsOf(truth, 200), turned, Path(), kEpoch);
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_LT(errors[1].median, 0.01);
  EXPECT_NEAR(errors[2].median, 0.005 * kFocalLength, 0.3);
  EXPECT_NEAR(errors[0].rms, errors[2].rms / std::sqrt(2.0), 0.05);
}

TEST(MapReprojection, LeavesOutWhatACalibrationLacksAndWhatIsTooLittle) {
  const CalibrationResult truth = Truth();
  CalibrationResult without = truth;
  without.sensors.erase(without.sensors.begin());
  const auto errors = MeasureReprojection(SightingsOf(truth, 200), without, Path(), kEpoch);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_EQ(errors[0].lidar, "side");
  // 25 of each LiDAR are too few, 50 of both together not.
  const auto few = MeasureReprojection(SightingsOf(truth, 50), truth, Path(), kEpoch);
  ASSERT_EQ(few.size(), 1u);
  EXPECT_EQ(few[0].lidar, "");
}

TEST(MapReprojection, StandsInColumns) {
  const CalibrationResult truth = Truth();
  const auto errors = MeasureReprojection(SightingsOf(truth, 200), truth, Path(), kEpoch);
  const std::vector<ReprojectionColumn> columns{{"calibration", errors}, {"truth", {errors[0]}}};
  const std::string csv = CsvOf(columns), table = TableOf(columns);
  EXPECT_NE(csv.find("\ntruth,all,camera,200,0.0"), std::string::npos) << csv;
  EXPECT_EQ(csv.find("truth,side"), std::string::npos) << csv;
  EXPECT_NE(table.find("camera / all LiDARs (200 matches): calibration median 0.00 px"), std::string::npos)
      << table;
  EXPECT_EQ(TableOf(std::vector<ReprojectionColumn>{{"calibration", {}}}), "no camera shows the map\n");
}

}  // namespace
}  // namespace mlic::map_reprojection_test
