#include "mlic_core/pipeline/calibrator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "mlic_core/geometry/so3.h"
#include "support/simulated_input.h"

namespace mlic::calibrator_test {
namespace {

struct SimulatedRun {
  CalibrationResult result;
  std::vector<SensorCalibration> truth;
  Rig rig;
};

SimulatedRun CalibrateSimulated(const sim::SensorSet& sensors, sim::Scenario scenario, double duration,
                                std::uint64_t seed, bool with_noise, bool with_guess) {
  const SimulatedInput input =
      SimulateInput(sensors, DriveOptions(scenario, duration, seed, with_noise), with_guess);
  CalibrationObserver observer;
  return {Calibrate(input.rig, input.dataset, CancellationToken(), observer),
          sim::TrueCalibrations(input.sensors), input.rig};
}

double RotationErrorDeg(const SimulatedRun& run, std::size_t l) {
  return AngleBetween(run.result.sensors[l].calibration.T_imu_sensor.rotation,
                      run.truth[l].T_imu_sensor.rotation) *
         180.0 / M_PI;
}
Eigen::Vector3d TranslationError(const SimulatedRun& run, std::size_t l) {
  return run.result.sensors[l].calibration.T_imu_sensor.translation - run.truth[l].T_imu_sensor.translation;
}
Eigen::Vector3d DistanceFromGuess(const SimulatedRun& run, std::size_t l) {
  return run.result.sensors[l].calibration.T_imu_sensor.translation -
         run.rig.lidars[l].guess->T_imu_sensor.translation;
}
double OffsetError(const SimulatedRun& run, std::size_t l) {
  return std::abs(run.result.sensors[l].calibration.time_offset - run.truth[l].time_offset);
}

TEST(Calibration, NoiseFreeHandHeldDriveGivesTheTruth) {
  const SimulatedRun run =
      CalibrateSimulated(ConfiguredSensors("handheld.yaml"), sim::Scenario::kHandheld, 15.0, 2, false, false);
  ASSERT_TRUE(run.result.Trusted());
  EXPECT_LT(RotationErrorDeg(run, 0), 1e-3);
  EXPECT_LT(TranslationError(run, 0).norm(), 1e-4);
  EXPECT_LT(OffsetError(run, 0), 2e-6);
}

TEST(Calibration, NoisyHandHeldDriveNeedsNoGuessAndKeepsItsSigmas) {
  const SimulatedRun run =
      CalibrateSimulated(ConfiguredSensors("handheld.yaml"), sim::Scenario::kHandheld, 20.0, 1, true, false);
  ASSERT_TRUE(run.result.Trusted());
  EXPECT_LT(RotationErrorDeg(run, 0), 0.016);
  EXPECT_LT(TranslationError(run, 0).norm(), 2e-3);
  EXPECT_LT(OffsetError(run, 0), 4e-5);
  const PoseSigma& sigma = run.result.sensors[0].sigma;
  for (int a = 0; a < 3; ++a) EXPECT_LT(std::abs(TranslationError(run, 0)[a]), 4.0 * sigma.translation[a]);
  EXPECT_LT(OffsetError(run, 0), 4.0 * sigma.time_offset);
}

TEST(Calibration, FourLidarsOfACarShareTheirMap) {
  const SimulatedRun run = CalibrateSimulated(ConfiguredSensors("paper_rig_lidars.yaml"),
                                              sim::Scenario::kFigureEight, 15.0, 1, true, true);
  ASSERT_TRUE(run.result.Trusted());
  ASSERT_EQ(run.result.sensors.size(), 4u);
  for (std::size_t l = 0; l < 4; ++l) {
    EXPECT_LT(RotationErrorDeg(run, l), 0.06);
    EXPECT_LT(TranslationError(run, l).head<2>().norm(), 0.01);
    EXPECT_LT(OffsetError(run, l), 8e-4);
  }
  ASSERT_EQ(run.result.pairs.size(), 6u);
  for (const PairResult& pair : run.result.pairs) {
    RigidTransform T_imu_a, T_imu_b;
    for (std::size_t l = 0; l < 4; ++l) {
      if (run.result.sensors[l].name == pair.a) T_imu_a = run.truth[l].T_imu_sensor;
      if (run.result.sensors[l].name == pair.b) T_imu_b = run.truth[l].T_imu_sensor;
    }
    const RigidTransform truth = T_imu_a.Inverse() * T_imu_b;
    EXPECT_LT(AngleBetween(pair.T_a_b.rotation, truth.rotation) * 180.0 / M_PI, 0.02);
    EXPECT_LT((pair.T_a_b.translation - truth.translation).norm(), 3e-3);
  }
}

TEST(Calibration, PlanarDriveHoldsTheHeight) {
  const SimulatedRun run = CalibrateSimulated(WithFirstLidars(ConfiguredSensors("paper_rig_lidars.yaml"), 2),
                                              sim::Scenario::kPlanar, 20.0, 1, true, true);
  ASSERT_TRUE(run.result.Trusted());
  ASSERT_EQ(run.result.sensors.size(), 2u);
  for (const SensorResult& sensor : run.result.sensors) {
    EXPECT_FALSE(sensor.translation_observable[2]) << sensor.name;
    EXPECT_TRUE(sensor.translation_observable[0] && sensor.translation_observable[1]) << sensor.name;
    ASSERT_EQ(sensor.unobservable.size(), 1u);
    EXPECT_GT(std::abs(sensor.unobservable[0].direction.z()), 0.99);
    EXPECT_NEAR(sensor.unobservable[0].sigma, 0.1 / std::sqrt(2.0), 0.002)
        << "the mean of two guesses of 0.1 m";
  }
  // The map places the LiDARs against each other, the guesses all of them over the IMU.
  double off = 0.0;
  for (std::size_t l = 0; l < 2; ++l) {
    off += run.result.sensors[l].unobservable[0].direction.dot(DistanceFromGuess(run, l)) / 2.0;
  }
  EXPECT_NEAR(TranslationError(run, 0).z(), TranslationError(run, 1).z(), 3e-3);
  EXPECT_NEAR(off, 0.0, 1e-3);
}

TEST(Calibration, WhatAPlanarDriveDoesNotShowStandsAtTheGuess) {
  const SimulatedRun run = CalibrateSimulated(WithHalfThePoints(ConfiguredSensors("handheld.yaml")),
                                              sim::Scenario::kPlanar, 15.0, 2, true, true);
  ASSERT_EQ(run.result.sensors.size(), 1u);
  const std::vector<UnobservableDirection>& open = run.result.sensors[0].unobservable;
  ASSERT_EQ(open.size(), 1u);
  ASSERT_EQ(open[0].quantity, UnobservableDirection::Quantity::kTranslation);
  EXPECT_NEAR(open[0].direction.dot(DistanceFromGuess(run, 0)), 0.0, 1e-6);
  EXPECT_NEAR(open[0].sigma, 0.1, 1e-4) << "the guess's own";
}

TEST(Calibration, PlanarDriveWithoutGuessIsRefused) {
  EXPECT_FALSE(CalibrateSimulated(WithHalfThePoints(ConfiguredSensors("handheld.yaml")),
                                  sim::Scenario::kPlanar, 12.0, 1, true, false)
                   .result.Trusted());
}

// Given the wrong way round, the guess is metres off along the axes that the drive shows, and right by no
// more than chance along the one that it does not.
TEST(Calibration, GuessTheWrongWayRoundDecidesNothing) {
  sim::SensorSet sensors = WithHalfThePoints(ConfiguredSensors("handheld.yaml"));
  sensors.lidars[0].calibration.T_imu_sensor = {
      Eigen::Quaterniond(Eigen::AngleAxisd(0.03, Eigen::Vector3d(0.6, 0.0, 0.8))), {0.9, -0.3, 0.4}};
  SimulatedInput input = SimulateInput(sensors, DriveOptions(sim::Scenario::kPlanar, 15.0, 3), true);
  const RigidTransform truth = sim::TrueCalibrations(sensors)[0].T_imu_sensor;
  input.rig.lidars[0].guess->T_imu_sensor = truth.Inverse();
  CalibrationObserver observer;
  const CalibrationResult result = Calibrate(input.rig, input.dataset, CancellationToken(), observer);
  EXPECT_FALSE(result.Trusted());
  EXPECT_TRUE(std::any_of(result.reasons.begin(), result.reasons.end(), [](const std::string& reason) {
    return reason.find("contradicts the given T_imu_sensor") != std::string::npos;
  }));
}

TEST(Calibration, DrivesWithoutExcitationAreRefusedThoughThereIsAGuess) {
  for (const auto scenario : {sim::Scenario::kStatic, sim::Scenario::kStraight, sim::Scenario::kCircle}) {
    const SimulatedRun run = CalibrateSimulated(WithHalfThePoints(ConfiguredSensors("handheld.yaml")),
                                                scenario, 8.0, 1, true, true);
    EXPECT_FALSE(run.result.Trusted());
    EXPECT_FALSE(run.result.reasons.empty());
  }
}

TEST(Calibration, SameInputGivesSameNumbers) {
  const SimulatedRun a = CalibrateSimulated(WithHalfThePoints(ConfiguredSensors("handheld.yaml")),
                                            sim::Scenario::kHandheld, 8.0, 4, true, false);
  const SimulatedRun b = CalibrateSimulated(WithHalfThePoints(ConfiguredSensors("handheld.yaml")),
                                            sim::Scenario::kHandheld, 8.0, 4, true, false);
  ASSERT_EQ(a.result.sensors.size(), b.result.sensors.size());
  for (std::size_t l = 0; l < a.result.sensors.size(); ++l) {
    EXPECT_EQ(a.result.sensors[l].calibration.T_imu_sensor.translation,
              b.result.sensors[l].calibration.T_imu_sensor.translation);
    EXPECT_EQ(a.result.sensors[l].calibration.time_offset, b.result.sensors[l].calibration.time_offset);
  }
}

}  // namespace
}  // namespace mlic::calibrator_test
