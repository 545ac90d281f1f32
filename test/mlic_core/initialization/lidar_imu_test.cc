#include "mlic_core/initialization/lidar_imu.h"

#include <gtest/gtest.h>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/guess_check.h"
#include "support/simulated_input.h"

namespace mlic::lidar_imu_test {
namespace {

constexpr double kDegree = M_PI / 180.0;

DriveOdometry Odometry(const SimulatedInput& input) {
  return RunDriveOdometry(input.rig, input.dataset.drives[0], CancellationToken(), [](double) {});
}

// A transform that was given the wrong way round, and a drive that shows all axes.
TEST(Initialization, AGuessThatNothingFitsIsDropped) {
  const sim::SensorSet sensors = ConfiguredSensors("handheld.yaml");
  SimulatedInput input = SimulateInput(sensors, DriveOptions(sim::Scenario::kHandheld, 8.0, 4), false);
  const RigidTransform truth = sensors.lidars[0].calibration.T_imu_sensor;
  input.rig.lidars[0].guess = ExtrinsicGuess{truth.Inverse()};
  ASSERT_GT(AngleBetween(truth.rotation, truth.Inverse().rotation), 60.0 * kDegree);
  const AngularRateAlignment found = Odometry(input).alignments[0];
  ASSERT_TRUE(found.valid);
  EXPECT_LT(AngleBetween(found.R_imu_lidar, truth.rotation), 0.2 * kDegree);
  EXPECT_NEAR(found.time_offset, sensors.lidars[0].calibration.time_offset, 2e-3);
}

// A rosette in a corridor whose scans go into the map at wrong poses after a while and lead all others
// astray: 159 deg off, and not usable, where the map holds all of them.
TEST(Initialization, ScansThatWereLostDoNotSpoilTheRest) {
  sim::SensorSet sensors = ConfiguredSensors("dual_rosette.yaml");
  sensors.lidars.resize(1);
  sim::SimulationOptions options = DriveOptions(sim::Scenario::kHandheld, 15.0, 13);
  options.world = sim::WorldFamily::kCorridor;
  options.world_seed = 13;
  const AngularRateAlignment found = Odometry(SimulateInput(sensors, options, false)).alignments[0];
  ASSERT_TRUE(IsUsable(found));
  const SensorCalibration& truth = sensors.lidars[0].calibration;
  EXPECT_LT(AngleBetween(found.R_imu_lidar, truth.T_imu_sensor.rotation), 0.2 * kDegree);
  EXPECT_NEAR(found.time_offset, truth.time_offset, 2e-3);
}

// A car among trees, with few rings: the velocity of one scan does not predict the next well enough.
TEST(Initialization, TheGyroscopeAndTheGuessFindScansAmongTrees) {
  sim::SensorSet sensors = ConfiguredSensors("spinning_car.yaml");
  sim::LidarModel& model = sensors.lidars[0].model;
  model.rings = 16;
  model.vertical_fov_deg[0] = -15.0;
  model.vertical_fov_deg[1] = 15.0;
  sim::SimulationOptions options = DriveOptions(sim::Scenario::kFigureEight, 12.0, 9);
  options.world = sim::WorldFamily::kGrove;
  options.world_seed = 9;
  SimulatedInput input = SimulateInput(sensors, options, false);
  input.rig.lidars[0].guess.reset();
  ASSERT_FALSE(IsUsable(Odometry(input).alignments[0]));
  const SensorCalibration& truth = sensors.lidars[0].calibration;
  ExtrinsicGuess guess{truth.T_imu_sensor};
  guess.T_imu_sensor.rotation = ExpQuaternion({0.05, -0.05, 0.06}) * guess.T_imu_sensor.rotation;
  input.rig.lidars[0].guess = guess;
  const AngularRateAlignment found = Odometry(input).alignments[0];
  ASSERT_TRUE(IsUsable(found));
  EXPECT_LT(AngleBetween(found.R_imu_lidar, truth.T_imu_sensor.rotation), 1.0 * kDegree);
  EXPECT_NEAR(found.time_offset, truth.time_offset, 5e-3);
}

TEST(Initialization, SaysWhetherTheMotionOrTheLidarIsAtFault) {
  const sim::SensorSet sensors = ConfiguredSensors("handheld.yaml");
  SimulatedInput input = SimulateInput(sensors, DriveOptions(sim::Scenario::kHandheld, 6.0, 4), false);
  const auto problem = [&] {
    const std::vector<DriveOdometry> odometry{Odometry(input)};
    return Initialize(input.rig, input.dataset, odometry, CancellationToken()).problems.at(0);
  };
  Drive& drive = input.dataset.drives[0];
  const LidarScan still = drive.lidars[0].scans[10];
  for (LidarScan& scan : drive.lidars[0].scans) scan.points = still.points;  // a driver that hangs
  EXPECT_NE(problem().find("the LiDARs' scans cannot be followed"), std::string::npos) << problem();
  for (ImuSample& sample : drive.imu) sample.angular_velocity *= 1e-3;
  EXPECT_NE(problem().find("the drive turns too little"), std::string::npos) << problem();
  drive.imu.resize(drive.imu.size() / 2);
  EXPECT_NE(problem().find("the drive lasts less than 5 s"), std::string::npos) << problem();
}

TEST(GuessedPose, JudgesByTheSigmasOfTheGuess) {
  LidarConfig config;
  config.name = "front";
  EXPECT_TRUE(IsLostFromGuess(config, RigidTransform()));
  EXPECT_NE(WhyRejected(config).find("front: "), std::string::npos);
  config.guess = ExtrinsicGuess();
  config.guess->sigma_translation = Eigen::Vector3d(0.1, 0.1, 0.3);
  const auto moved = [](const Eigen::Vector3d& degrees, const Eigen::Vector3d& translation) {
    return RigidTransform{FromRollPitchYaw(degrees * kDegree), translation};
  };
  EXPECT_FALSE(IsLostFromGuess(config, moved({4.81, 0.0, 0.0}, {0.1, -0.1, 0.5})));
  EXPECT_TRUE(IsLostFromGuess(config, moved({0.0, 0.0, 0.0}, {0.3, 0.0, 0.0})));
  EXPECT_TRUE(IsLostFromGuess(config, moved({0.0, -12.0, 0.0}, {0.0, 0.0, 0.0})));
  EXPECT_FALSE(ContradictsGuess(*config.guess, moved({0.0, 15.0, 0.0}, {0.3, 0.0, 0.0})));
  const RigidTransform far = moved({0.0, 25.0, 0.0}, {0.3, 0.4, 0.0});
  EXPECT_TRUE(ContradictsGuess(*config.guess, far));
  EXPECT_NE(DescribeDistance(*config.guess, far).find("25.0 deg and 0.50 m"), std::string::npos);
}

}  // namespace
}  // namespace mlic::lidar_imu_test
