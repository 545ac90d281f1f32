#include "mlic_core/pipeline/still_pair.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "mlic_core/crossmodal/view_selection.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/simulation.h"
#include "support/source_directory.h"

namespace mlic::still_pair_test {
namespace {

constexpr double kDegree = M_PI / 180.0;

// One scan of the paper rig's front LiDAR and a photo of its front camera, the car parked in the yard.
struct Parked {
  Rig rig;
  ScanPhoto pair;
  RigidTransform truth;  // T_lidar_camera
};

// The car parks once for all tests.
Parked MakeParked() {
  sim::SensorSet sensors = sim::LoadSensorSet(SourceDirectory() + "/config/simulation/paper_rig.yaml");
  sensors.lidars.resize(1);
  sensors.cameras.resize(1);
  sim::SimulationOptions simulation;
  simulation.scenario = sim::Scenario::kStatic;
  simulation.duration = 0.5;
  const Drive drive = sim::SimulateDrive(sensors, simulation, [](LidarScan&) {});
  Parked parked;
  for (const LidarPoint& point : drive.lidars[0].scans[1].points) {
    if (point.position.norm() < 0.5f) continue;
    MapReturn r;
    r.position = r.beam = point.position;
    r.intensity = point.intensity;
    r.ring = point.ring;
    parked.pair.returns.push_back(r);
  }
  parked.pair.photo = drive.cameras[0].images->Load(1);
  parked.truth =
      sim::TrueCalibrations(sensors)[0].T_imu_sensor.Inverse() * sensors.cameras[0].calibration.T_imu_sensor;
  LidarConfig lidar;
  lidar.name = "front_lidar";
  CameraConfig camera;
  camera.name = "front_camera";
  camera.model = sensors.cameras[0].intrinsics.model;
  camera.intrinsics = sensors.cameras[0].intrinsics.parameters;
  ExtrinsicGuess guess;
  guess.T_imu_sensor = parked.truth;
  guess.T_imu_sensor.rotation =
      ExpQuaternion(kDegree * Eigen::Vector3d(0.8, -0.9, 0.7)) * parked.truth.rotation;
  guess.T_imu_sensor.translation += Eigen::Vector3d(0.02, -0.03, 0.02);
  guess.sigma_rotation.setConstant(kDegree);
  guess.sigma_translation.setConstant(0.05);
  camera.guess = guess;
  parked.rig.lidars = {lidar};
  parked.rig.cameras = {camera};
  return parked;
}

const Parked& Park() {
  static const Parked kParked = MakeParked();
  return kParked;
}

TEST(PairRegistration, FindsTheCameraOfOneScanAndItsPhoto) {
  const Parked& parked = Park();
  const PairRegistration done = RegisterPairs(parked.rig, {parked.pair});
  ASSERT_TRUE(done.result.Trusted()) << done.result.reasons.front();
  const RigidTransform& found = done.result.sensors[1].calibration.T_imu_sensor;
  const double rotation = AngleBetween(found.rotation, parked.truth.rotation) / kDegree;
  const double translation = (found.translation - parked.truth.translation).norm();
  RecordProperty("rotation_deg", std::to_string(rotation));
  RecordProperty("translation_mm", std::to_string(1e3 * translation));
  EXPECT_LT(rotation, 0.3);
  EXPECT_LT(translation, 0.05);
  EXPECT_GT(done.score_after, done.score_before + 0.05);
  EXPECT_GT(done.score_after, done.score_elsewhere + 0.05);
  EXPECT_LT(done.nid_after, done.nid_before);
}

TEST(PairRegistration, RefusesAPhotoOfAnotherPlace) {
  // Upside down and half as large, for speed.
  Rig rig = Park().rig;
  ScanPhoto pair = Park().pair;
  cv::Mat other;
  cv::resize(pair.photo, other, {}, 0.5, 0.5, cv::INTER_AREA);
  cv::flip(other, pair.photo, -1);
  const CameraIntrinsics whole{rig.cameras[0].model, 1280, 800, *rig.cameras[0].intrinsics};
  rig.cameras[0].intrinsics = ScaledIntrinsics(whole, 0.5).parameters;
  const PairRegistration done = RegisterPairs(rig, {pair});
  EXPECT_FALSE(done.result.Trusted());
  EXPECT_TRUE(done.result.sensors.empty());
}

}  // namespace
}  // namespace mlic::still_pair_test
