#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/evaluation/methods/hand_eye_method.h"
#include "mlic_core/evaluation/methods/pairwise_method.h"
#include "mlic_core/geometry/so3.h"
#include "support/simulated_input.h"

namespace mlic::methods_test {
namespace {

// The front and the left LiDAR of the paper's car, which share a part of their view.
class Methods : public ::testing::Test {
 protected:
  Methods() {
    sim::SensorSet sensors = ConfiguredSensors("paper_rig_lidars.yaml");
    sensors.lidars.erase(sensors.lidars.begin() + 3);
    sensors.lidars.erase(sensors.lidars.begin() + 1);
    input_ = SimulateInput(sensors, DriveOptions(sim::Scenario::kFigureEight, 10.0, 2), true);
  }

  // Degrees; of the pair and of the first LiDAR to the IMU.
  double PairError(const CalibrationResult& result) const {
    const auto truth = sim::TrueCalibrations(input_.sensors);
    return Degrees(
        result.sensors[0].calibration.T_imu_sensor.Inverse() * result.sensors[1].calibration.T_imu_sensor,
        truth[0].T_imu_sensor.Inverse() * truth[1].T_imu_sensor);
  }
  double ImuError(const CalibrationResult& result) const {
    return Degrees(result.sensors[0].calibration.T_imu_sensor,
                   sim::TrueCalibrations(input_.sensors)[0].T_imu_sensor);
  }
  static double Degrees(const RigidTransform& a, const RigidTransform& b) {
    return Log(Eigen::Quaterniond(a.rotation * b.rotation.conjugate())).norm() * 180.0 / M_PI;
  }

  SimulatedInput input_;
  CancellationToken cancellation_;
};

TEST_F(Methods, AreAsGoodAsWhatTheyUse) {
  const CalibrationResult hand_eye = CalibrateByHandEye(input_.rig, input_.dataset, {}, cancellation_);
  ASSERT_EQ(hand_eye.sensors.size(), 2u);
  EXPECT_EQ(hand_eye.verdict, Verdict::kRefused) << "it is not for use";
  EXPECT_LT(ImuError(hand_eye), 0.3);
  EXPECT_LT(PairError(hand_eye), 0.3);

  std::vector<std::string> told;
  const CalibrationResult pairwise = CalibratePairwise(
      input_.rig, input_.dataset, cancellation_, [&](const std::string& pair) { told.push_back(pair); });
  EXPECT_EQ(told, (std::vector<std::string>{"front_lidar to the IMU", "left_lidar to front_lidar"}));
  ASSERT_EQ(pairwise.sensors.size(), 2u);
  EXPECT_LT(ImuError(pairwise), 0.05);
  EXPECT_LT(PairError(pairwise), 0.02);
  EXPECT_LT(PairError(pairwise), PairError(hand_eye));
  EXPECT_TRUE(pairwise.sensors[1].sigma.rotation.isZero()) << "chained poses claim no sigmas";
}

TEST(HandEyeMethod, AsksForALidar) {
  Rig cameras;
  cameras.cameras.resize(2);
  EXPECT_THROW(CalibrateByHandEye(cameras, Dataset(), {}, CancellationToken()), InputError);
}

}  // namespace
}  // namespace mlic::methods_test
