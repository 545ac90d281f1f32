#include "mlic_core/pipeline/clock_review.h"

#include <gtest/gtest.h>

#include "mlic_core/pipeline/joint_adjustment.h"
#include "mlic_core/summary/result_assembly.h"
#include "support/simulated_input.h"

namespace mlic {
namespace {

// The result of a simulated hand-held drive of 12 s whose LiDAR's clock drifts, s/s.
struct Calibrated {
  explicit Calibrated(double drift) {
    sim::SensorSet sensors = ConfiguredSensors("handheld.yaml");
    sensors.lidars[0].calibration.clock_drift = drift;
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

  static constexpr double kDuration = 12.0;  // s
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

TEST(ClockReview, FindsASmallDriftInTheRounds) {
  const Calibrated calibrated(6e-5);
  EXPECT_EQ(calibrated.odometry.clocks[0].drift, 0.0);
  ExpectFound(calibrated, 1e-5);
}

TEST(ClockReview, StartsFromAGrossDrift) {
  const Calibrated calibrated(1e-3);
  EXPECT_NEAR(calibrated.odometry.clocks[0].drift, 1e-3, 3e-4);
  ExpectFound(calibrated, 1e-5);
}

}  // namespace
}  // namespace mlic
