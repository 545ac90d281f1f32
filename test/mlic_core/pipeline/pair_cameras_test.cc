// Cameras to a LiDAR where nothing ties them to the IMU.
#include <gtest/gtest.h>

#include <algorithm>

#include "mlic_core/common/join.h"
#include "mlic_core/crossmodal/view_selection.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/pipeline/calibrator.h"
#include "support/simulated_input.h"

namespace mlic {
namespace {

CalibrationResult Calibrated(const SimulatedInput& input) {
  CalibrationObserver observer;
  return Calibrate(input.rig, input.dataset, CancellationToken(), observer);
}

// The front LiDAR of the paper's car and the camera below it, whose lens is known. scale: of its images.
SimulatedInput LidarAndCamera(sim::Scenario scenario, double duration, double scale) {
  sim::SensorSet sensors = ConfiguredSensors("paper_rig.yaml");
  sensors.lidars.resize(1);
  sensors.cameras.resize(1);
  CameraIntrinsics& intrinsics = sensors.cameras[0].intrinsics;
  intrinsics = ScaledIntrinsics(intrinsics, scale);
  SimulatedInput input = SimulateInput(sensors, DriveOptions(scenario, duration, 1), true);
  input.rig.cameras[0].intrinsics = intrinsics.parameters;
  return input;
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

// Neither too good nor worthless.
void ExpectHonest(const PairResult& pair, const PairError& error, double largest_sigma_deg) {
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(std::abs(error.turn[k]), 3.0 * pair.sigma.rotation[k]);
    EXPECT_LT(std::abs(error.shift[k]), 3.0 * pair.sigma.translation[k]);
  }
  EXPECT_LT(pair.sigma.rotation.maxCoeff(), largest_sigma_deg * M_PI / 180.0);
}

TEST(PairCameras, AParkedCarGivesTheCameraThatSeesWhatItsLidarSeesAndNamesTheOther) {
  SimulatedInput input = LidarAndCamera(sim::Scenario::kStatic, 2.0, 1.0);
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
  ExpectHonest(pair, error, 1.5);
  EXPECT_LT(error.turn.norm(), 0.3 * M_PI / 180.0);
  EXPECT_LT(error.shift.norm(), 0.06);
  ASSERT_FALSE(pair.unobservable.empty());
  EXPECT_EQ(pair.unobservable.back().quantity, UnobservableDirection::Quantity::kTimeOffset);
  const bool named = std::any_of(result.reasons.begin(), result.reasons.end(), [](const std::string& reason) {
    return reason.rfind("unplaced: ", 0) == 0 && reason.find("T_imu_sensor") != std::string::npos;
  });
  EXPECT_TRUE(named);
}

TEST(PairCameras, AStraightDriveGivesTheCameraAboutTheLidar) {
  const SimulatedInput input = LidarAndCamera(sim::Scenario::kStraight, 6.0, 0.5);
  const CalibrationResult result = Calibrated(input);
  ASSERT_EQ(result.verdict, Verdict::kPartial) << Joined(result.reasons, "\n");
  ASSERT_EQ(result.pairs.size(), 1u);
  const PairError error = ErrorOf(result.pairs[0], input);
  ExpectHonest(result.pairs[0], error, 0.2);
  EXPECT_LT(error.turn.norm(), 0.1 * M_PI / 180.0);
  // Along the way, here the LiDAR's z, the clocks' difference says the same as a move.
  EXPECT_LT(error.shift.head<2>().norm(), 0.03);
}

}  // namespace
}  // namespace mlic
