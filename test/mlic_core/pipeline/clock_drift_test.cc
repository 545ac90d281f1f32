#include <gtest/gtest.h>

#include "mlic_core/pipeline/joint_adjustment.h"
#include "mlic_core/summary/result_assembly.h"
#include "support/simulated_input.h"

namespace mlic::clock_drift_test {
namespace {

constexpr double kDuration = 12.0;  // s

// The result of a simulated hand-held drive whose first LiDARs' clocks drift by so much, s/s.
struct Calibrated {
  Calibrated(sim::SensorSet sensors, const std::vector<double>& drifts) {
    for (std::size_t l = 0; l < drifts.size(); ++l) {
      sensors.lidars[l].calibration.clock_drift = drifts[l];
    }
    const SimulatedInput input =
        SimulateInput(sensors, DriveOptions(sim::Scenario::kHandheld, kDuration, 7), false);
    CancellationToken token;
    CalibrationObserver observer;
    const AdjustmentContext context{
        input.rig, input.dataset, observer, {token, [](double) {}, [](const auto&) {}}};
    odometry = RunDriveOdometry(input.rig, input.dataset.drives[0], token, [](double) {});
    Adjustment adjustment =
        StartAdjustment(input.rig, input.dataset, Initialize(input.rig, input.dataset, {odometry}, token));
    adjustment = AdjustJointly(std::move(adjustment), context, {});
    MeasureUncertainty(context, &adjustment);
    AssembleResult(input.rig, input.dataset, adjustment, &result);
    truth = sensors.lidars[0].calibration;
    middle = TimeFrom(sim::kSimulationEpoch, 0.5 * kDuration);
  }

  DriveOdometry odometry;
  CalibrationResult result;
  SensorCalibration truth;
  TimeNs middle;
};

void ExpectFound(const Calibrated& calibrated, double largest_sigma) {
  ASSERT_TRUE(calibrated.result.Trusted());
  const SensorResult& sensor = calibrated.result.sensors[0];
  ASSERT_TRUE(sensor.calibration.clock_drift.has_value());
  EXPECT_LT(sensor.drift_sigma, largest_sigma);
  EXPECT_LT(std::abs(*sensor.calibration.clock_drift - *calibrated.truth.clock_drift),
            4.0 * sensor.drift_sigma);
  const double at_reference =
      calibrated.truth.time_offset +
      *calibrated.truth.clock_drift * SecondsSince(calibrated.middle, sensor.clock_reference);
  EXPECT_LT(std::abs(sensor.calibration.time_offset - at_reference), 4.0 * sensor.sigma.time_offset);
  ASSERT_EQ(calibrated.result.warnings.size(), 1u);
  EXPECT_NE(calibrated.result.warnings[0].find("its clock drifts by"), std::string::npos);
}

TEST(ClockDrift, FindsASmallDriftInTheRounds) {
  const Calibrated calibrated(ConfiguredSensors("handheld.yaml"), {6e-5});
  EXPECT_EQ(calibrated.odometry.clocks[0].drift, 0.0);
  ExpectFound(calibrated, 1e-5);
}

TEST(ClockDrift, StartsFromAGrossDrift) {
  const Calibrated calibrated(ConfiguredSensors("handheld.yaml"), {1e-3});
  EXPECT_NEAR(calibrated.odometry.clocks[0].drift, 1e-3, 3e-4);
  ExpectFound(calibrated, 1e-5);
}

// Against the IMU, whose gyroscope is poor, neither drift is shown; against each other both are.
TEST(ClockDrift, FindsWhatLidarsDriftAgainstEachOther) {
  sim::SensorSet sensors = ConfiguredSensors("dual_rosette.yaml");
  sensors.imu.noise.gyroscope = 5e-3;
  sensors.imu.noise.accelerometer = 5e-2;
  const Calibrated calibrated(sensors, {6e-5, 0.0});
  const std::vector<SensorResult>& found = calibrated.result.sensors;
  ASSERT_EQ(found.size(), 2u);
  for (const SensorResult& sensor : found) {
    ASSERT_TRUE(sensor.calibration.clock_drift.has_value());
    EXPECT_LT(std::abs(*sensor.calibration.clock_drift), 3.0 * sensor.drift_sigma);
  }
  EXPECT_LT(std::abs(*found[1].calibration.clock_drift), 4.0 * found[1].drift_sigma);
  EXPECT_NEAR(*found[0].calibration.clock_drift - *found[1].calibration.clock_drift, 6e-5, 3e-5);
  for (const std::string& warning : calibrated.result.warnings) {
    EXPECT_EQ(warning.find("its clock drifts by"), std::string::npos) << warning;
  }
}

}  // namespace
}  // namespace mlic::clock_drift_test
