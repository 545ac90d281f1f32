// IMUs as real ones are: the calibration stands, and its sigmas hold.

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/pipeline/calibrator.h"
#include "support/simulated_input.h"

namespace mlic::imu_test {
namespace {

constexpr double kDegree = M_PI / 180.0;

CalibrationResult CalibrateHandheld(const sim::SensorSet& sensors, double duration, bool with_noise) {
  const SimulatedInput input =
      SimulateInput(sensors, DriveOptions(sim::Scenario::kHandheld, duration, 1, with_noise), false);
  CalibrationObserver observer;
  return Calibrate(input.rig, input.dataset, CancellationToken(), observer);
}

// The accelerometer 3 deg off the gyroscope, in a place of less gravity.
sim::SensorSet TurnedHandheld() {
  sim::SensorSet sensors = WithHalfThePoints(ConfiguredSensors("handheld.yaml"));
  sensors.imu.calibration.accelerometer_matrix = ExpMatrix(3.0 * kDegree * Eigen::Vector3d(0.6, -0.48, 0.64));
  sensors.imu.gravity = 9.79;
  return sensors;
}

double AlignmentErrorDeg(const CalibrationResult& result, const sim::SensorSet& sensors) {
  return Log(Eigen::Matrix3d(result.imu.accelerometer_matrix *
                             sensors.imu.calibration.accelerometer_matrix.transpose()))
             .norm() /
         kDegree;
}

TEST(TurnedAccelerometer, IsFoundToNumericalPrecisionWithoutNoise) {
  const sim::SensorSet sensors = TurnedHandheld();
  const CalibrationResult result = CalibrateHandheld(sensors, 15.0, false);
  ASSERT_TRUE(result.Trusted());
  const RigidTransform &found = result.sensors[0].calibration.T_imu_sensor,
                       &truth = sensors.lidars[0].calibration.T_imu_sensor;
  EXPECT_LT(AngleBetween(found.rotation, truth.rotation) / kDegree, 1e-3);
  EXPECT_LT((found.translation - truth.translation).norm(), 2e-4);
  EXPECT_LT(AlignmentErrorDeg(result, sensors), 2e-3);
  EXPECT_NEAR(result.gravity.z(), -9.79, 1e-3);
}

TEST(TurnedAccelerometer, IsFoundWithinSigmasInNoise) {
  const sim::SensorSet sensors = TurnedHandheld();
  const CalibrationResult result = CalibrateHandheld(sensors, 20.0, true);
  ASSERT_TRUE(result.Trusted());
  const SensorResult& lidar = result.sensors[0];
  const RigidTransform& truth = sensors.lidars[0].calibration.T_imu_sensor;
  const Eigen::Vector3d translation = lidar.calibration.T_imu_sensor.translation - truth.translation;
  EXPECT_LT(translation.norm(), 3e-3);
  EXPECT_LT(translation.cwiseQuotient(lidar.sigma.translation).cwiseAbs().maxCoeff(), 4.0);
  EXPECT_LT(AngleBetween(lidar.calibration.T_imu_sensor.rotation, truth.rotation) / kDegree, 0.016);
  ASSERT_TRUE(result.alignment.has_value());
  EXPECT_EQ(result.alignment->axes, ImuAxes::kGyroscope);
  EXPECT_LT(AlignmentErrorDeg(result, sensors), 0.06);
  EXPECT_LT(result.alignment->sigma.maxCoeff(), 0.03 * kDegree);
}

// Biases that change by some mrad/s as the IMU warms up: held constant, they would contradict the trajectory.
TEST(ColdImu, IsFollowedAsItWarmsUp) {
  sim::SensorSet sensors = WithHalfThePoints(ConfiguredSensors("handheld.yaml"));
  sensors.imu.warm_up = {{0.005, -0.0035, 0.0025}, {-0.03, 0.02, 0.024}, 30.0};
  const CalibrationResult result = CalibrateHandheld(sensors, 24.0, true);
  ASSERT_TRUE(result.Trusted());
  const SensorResult& lidar = result.sensors[0];
  const RigidTransform &found = lidar.calibration.T_imu_sensor,
                       &truth = sensors.lidars[0].calibration.T_imu_sensor;
  const Eigen::Vector3d rotation = Log(found.rotation * truth.rotation.conjugate());
  EXPECT_LT(rotation.cwiseQuotient(lidar.sigma.rotation).cwiseAbs().maxCoeff(), 4.0);
  EXPECT_LT(
      (found.translation - truth.translation).cwiseQuotient(lidar.sigma.translation).cwiseAbs().maxCoeff(),
      4.0);
  EXPECT_LT(rotation.norm() / kDegree, 0.01);
  // Half way the IMU has warmed up by a third.
  EXPECT_LT((result.imu.gyroscope_bias - sensors.imu.calibration.gyroscope_bias -
             (1.0 - std::exp(-0.4)) * sensors.imu.warm_up.gyroscope)
                .norm(),
            0.5e-3);
}

// Scale and shear of 0.3 percent, which nothing says but the data.
TEST(ScaledImu, IsFoundWhereTheRigFileAsksForBiasesAlone) {
  sim::SensorSet sensors = WithHalfThePoints(ConfiguredSensors("handheld.yaml"));
  ImuCalibration& imu = sensors.imu.calibration;
  imu.gyroscope_matrix << 1.003, 0.0, 0.0, -0.002, 0.996, 0.0, 0.004, -0.003, 1.002;
  imu.accelerometer_matrix << 0.997, 0.004, -0.001, 0.003, 1.002, 0.002, -0.003, 0.001, 1.004;
  const CalibrationResult result = CalibrateHandheld(sensors, 20.0, true);
  ASSERT_TRUE(result.Trusted());
  EXPECT_LT((result.imu.gyroscope_matrix - imu.gyroscope_matrix).cwiseAbs().maxCoeff(), 5e-4);
  EXPECT_LT((result.imu.accelerometer_matrix - imu.accelerometer_matrix).cwiseAbs().maxCoeff(), 1.5e-3);
  const SensorResult& lidar = result.sensors[0];
  const RigidTransform &found = lidar.calibration.T_imu_sensor,
                       &truth = sensors.lidars[0].calibration.T_imu_sensor;
  const Eigen::Vector3d rotation = Log(found.rotation * truth.rotation.conjugate());
  const Eigen::Vector3d translation = found.translation - truth.translation;
  EXPECT_LT(rotation.cwiseQuotient(lidar.sigma.rotation).cwiseAbs().maxCoeff(), 4.0);
  EXPECT_LT(translation.cwiseQuotient(lidar.sigma.translation).cwiseAbs().maxCoeff(), 4.0);
  EXPECT_LT(rotation.norm() / kDegree, 0.03);
}

// Butterworth low-passes of second order delay slow signals by sqrt(2) / (2 pi cut-off).
TEST(LaggingAccelerometer, IsFoundWhereItsFilterIsSlowerThanTheGyroscopes) {
  sim::SensorSet sensors = WithHalfThePoints(ConfiguredSensors("handheld.yaml"));
  sensors.imu.gyroscope_low_pass = 0.2;
  sensors.imu.accelerometer_low_pass = 0.1;
  const auto delay = [&](double cut_off) {
    return std::sqrt(2.0) / (2.0 * M_PI * cut_off * sensors.imu.rate);
  };
  const CalibrationResult result = CalibrateHandheld(sensors, 15.0, true);
  ASSERT_TRUE(result.Trusted());
  EXPECT_NEAR(result.imu.accelerometer_lag, delay(0.1) - delay(0.2), 3e-4);
  const SensorResult& lidar = result.sensors[0];
  const Eigen::Vector3d translation =
      lidar.calibration.T_imu_sensor.translation - sensors.lidars[0].calibration.T_imu_sensor.translation;
  EXPECT_LT(translation.cwiseQuotient(lidar.sigma.translation).cwiseAbs().maxCoeff(), 4.0);
}

}  // namespace
}  // namespace mlic::imu_test
