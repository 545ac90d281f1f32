// Cameras to a LiDAR where nothing ties them to the IMU.
#include <gtest/gtest.h>

#include <algorithm>

#include "mlic_core/common/join.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/pose_fit.h"
#include "mlic_core/pipeline/calibrator.h"
#include "mlic_core/summary/pair_assembly.h"
#include "support/simulated_input.h"

namespace mlic::pair_cameras_test {
namespace {

// What an offset is wrong by moves the pose that photos show by the root's motion in that time.
TEST(PairCameras, AnOffsetErrsAlongTheRootsMotion) {
  const Eigen::Vector3d turn(0.0, 0.02, 0.2), velocity(4.0, 0.3, 0.0);  // rad/s, m/s, of the root
  std::vector<TimedPose> poses{{0.0, RigidTransform()}};
  constexpr double kStep = 0.05;  // s
  for (int k = 1; k <= 60; ++k) {
    const RigidTransform step{ExpQuaternion(kStep * turn), kStep * velocity};
    poses.push_back({k * kStep, poses.back().pose * step});
  }
  const SplitSpline trajectory = SplineThrough(poses, KnotSpacing{0.1, 0.1});
  const RigidTransform truth{ExpQuaternion(Eigen::Vector3d(-1.2, 1.1, -1.3)),
                             Eigen::Vector3d(0.3, -0.5, 0.2)};
  constexpr double kOffset = 0.01;  // s
  const RigidTransform taken = trajectory.Pose(1.5).Inverse() * trajectory.Pose(1.5 + kOffset) * truth;
  const Eigen::Matrix<double, 7, 1> error = kOffset * ErrorOfOffset(trajectory, truth);
  EXPECT_LT((Log(taken.rotation * truth.rotation.conjugate()) - error.head<3>()).norm(), 2e-5);
  EXPECT_LT((taken.translation - truth.translation - error.segment<3>(3)).norm(), 5e-4);
  EXPECT_EQ(error[6], -kOffset);
}

CalibrationResult Calibrated(const SimulatedInput& input) {
  CalibrationObserver observer;
  return Calibrate(input.rig, input.dataset, CancellationToken(), observer);
}

// The car with the front LiDAR of the paper's and the camera below it, whose lens is known.
SimulatedInput FrontLidarAndCamera(const sim::SimulationOptions& options) {
  sim::SensorSet sensors = ConfiguredSensors("paper_rig.yaml");
  sensors.lidars.resize(1);
  sensors.cameras.resize(1);
  SimulatedInput input = SimulateInput(sensors, options, true);
  input.rig.cameras[0].intrinsics = sensors.cameras[0].intrinsics.parameters;
  return input;
}

sim::SimulationOptions InAStreet(sim::Scenario scenario, double duration, std::uint64_t seed) {
  sim::SimulationOptions options = DriveOptions(scenario, duration, seed);
  options.world = sim::WorldFamily::kStreet;
  options.world_seed = seed;
  return options;
}

struct PairError {
  Eigen::Vector3d turn, shift;  // rad, m
};

PairError ErrorOf(const PairResult& pair, const SimulatedInput& input) {
  const RigidTransform T_a_b = sim::TrueCalibrations(input.sensors)[0].T_imu_sensor.Inverse() *
                               input.sensors.cameras[0].calibration.T_imu_sensor;
  return {Log(Eigen::Quaterniond(pair.T_a_b.rotation * T_a_b.rotation.conjugate())),
          pair.T_a_b.translation - T_a_b.translation};
}

// Errors as claimed: within 3 sigmas each, and the six together within what chance leaves of 99 in 100
// (chi-square, 6 degrees of freedom).
void ExpectHonest(const PairResult& pair, const PairError& error) {
  const Eigen::Array3d turn = error.turn.array() / pair.sigma.rotation.array();
  const Eigen::Array3d shift = error.shift.array() / pair.sigma.translation.array();
  EXPECT_LT(turn.abs().maxCoeff(), 3.0);
  EXPECT_LT(shift.abs().maxCoeff(), 3.0);
  EXPECT_LT(turn.square().sum() + shift.square().sum(), 16.8);
}

TEST(PairCameras, AParkedCarGivesTheCameraThatSeesWhatItsLidarSeesAndNamesTheOther) {
  SimulatedInput input = FrontLidarAndCamera(DriveOptions(sim::Scenario::kStatic, 2.0, 1));
  CameraConfig other = input.rig.cameras[0];
  other.name = "unplaced";
  other.guess.reset();
  input.rig.cameras.insert(input.rig.cameras.begin(), other);
  std::vector<CameraRecording>& recordings = input.dataset.drives[0].cameras;
  recordings.push_back(recordings[0]);
  const CalibrationResult result = Calibrated(input);
  ASSERT_EQ(result.verdict, Verdict::kPartial) << Joined(result.reasons, "\n");
  EXPECT_EQ(result.root, input.rig.lidars[0].name);
  ASSERT_EQ(result.pairs.size(), 1u);
  const PairResult& pair = result.pairs[0];
  EXPECT_EQ(pair.b, input.rig.cameras[1].name);
  const PairError error = ErrorOf(pair, input);
  ExpectHonest(pair, error);
  EXPECT_LT(pair.sigma.rotation.maxCoeff(), 0.25 * M_PI / 180.0);
  EXPECT_LT(pair.sigma.translation.maxCoeff(), 0.04);
  EXPECT_LT(error.shift.norm(), 0.06);
  ASSERT_FALSE(pair.unobservable.empty());
  EXPECT_EQ(pair.unobservable.back().quantity, UnobservableDirection::Quantity::kTimeOffset);
  const bool named = std::any_of(result.reasons.begin(), result.reasons.end(), [](const std::string& reason) {
    return reason.rfind("unplaced: ", 0) == 0 && reason.find("T_imu_sensor") != std::string::npos;
  });
  EXPECT_TRUE(named);
  // Its picture; the other has neither a place nor a guess to draw.
  ASSERT_EQ(result.projections.size(), 1u);
  EXPECT_EQ(result.projections[0].camera, input.rig.cameras[1].name);
  EXPECT_TRUE(result.projections[0].found);
  EXPECT_GT(result.projections[0].after.size(), 1000u);
}

TEST(PairCameras, AParkedCameraFarFromItsGuessIsRefusedWithThePictureOfTheGuess) {
  SimulatedInput input = FrontLidarAndCamera(DriveOptions(sim::Scenario::kStatic, 1.0, 1));
  CameraConfig& camera = input.rig.cameras[0];
  const Eigen::AngleAxisd turn(25.0 * M_PI / 180.0, Eigen::Vector3d::UnitZ());
  camera.guess->T_imu_sensor.rotation = camera.guess->T_imu_sensor.rotation * Eigen::Quaterniond(turn);
  const CalibrationResult result = Calibrated(input);
  EXPECT_EQ(result.verdict, Verdict::kRefused);
  const bool named =
      std::any_of(result.reasons.begin(), result.reasons.end(), [&](const std::string& reason) {
        return reason.rfind(camera.name + ": its photos do not show the LiDARs' map", 0) == 0;
      });
  EXPECT_TRUE(named) << Joined(result.reasons, "\n");
  ASSERT_EQ(result.projections.size(), 1u);
  EXPECT_FALSE(result.projections[0].found);
  EXPECT_TRUE(result.projections[0].after.empty());
  EXPECT_GT(result.projections[0].guess.size(), 1000u);
}

// Three seconds do not show how the IMU is turned; the camera to the LiDAR they do, with the clocks that the
// gyroscope ties. Without the IMU an unknown offset of 10 ms moved it by 0.1 m along the way.
TEST(PairCameras, AShortDriveGivesTheCameraAsTheRefusedCalibrationHasIt) {
  const SimulatedInput input = FrontLidarAndCamera(InAStreet(sim::Scenario::kWeaving, 3.0, 21));
  const CalibrationResult result = Calibrated(input);
  ASSERT_EQ(result.verdict, Verdict::kPartial) << Joined(result.reasons, "\n");
  EXPECT_TRUE(result.sensors.empty());
  ASSERT_EQ(result.pairs.size(), 1u);
  const PairError error = ErrorOf(result.pairs[0], input);
  ExpectHonest(result.pairs[0], error);
  EXPECT_LT(result.pairs[0].sigma.rotation.maxCoeff(), 0.3 * M_PI / 180.0);
  EXPECT_LT(error.shift.norm(), 0.02);
}

// Of a street a single scan shows far facades and a floor at grazing angles, which is horizontal strokes in
// the photo and would fit best squeezed to the horizon: half a metre off.
TEST(PairCameras, AStreetsFloorIsNotSqueezedToTheHorizon) {
  const SimulatedInput input = FrontLidarAndCamera(InAStreet(sim::Scenario::kStatic, 1.0, 9));
  const CalibrationResult result = Calibrated(input);
  ASSERT_EQ(result.verdict, Verdict::kPartial) << Joined(result.reasons, "\n");
  ASSERT_EQ(result.pairs.size(), 1u);
  const PairError error = ErrorOf(result.pairs[0], input);
  ExpectHonest(result.pairs[0], error);
  EXPECT_LT(error.turn.norm(), 0.3 * M_PI / 180.0);
  EXPECT_LT(error.shift.norm(), 0.06);
}

}  // namespace
}  // namespace mlic::pair_cameras_test
