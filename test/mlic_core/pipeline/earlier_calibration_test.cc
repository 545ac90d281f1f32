#include "mlic_core/pipeline/earlier_calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::earlier_calibration_test {
namespace {

const Eigen::Vector3d kTranslationSigma(1e-3, 2e-3, 3e-3), kRotationSigma(1e-4, 2e-4, 3e-4);

SensorResult MakeSensor(const std::string& name, const Eigen::Vector3d& at) {
  SensorResult sensor;
  sensor.name = name;
  sensor.calibration.T_imu_sensor = {FromRollPitchYaw({0.1, 0.2, 0.3}), at};
  sensor.calibration.time_offset = 0.02;
  sensor.sigma = {kTranslationSigma, kRotationSigma, 1e-4};
  return sensor;
}

SensorResult MakeCamera(const std::string& name, const Eigen::Vector3d& at) {
  SensorResult camera = MakeSensor(name, at);
  camera.type = SensorResult::Type::kCamera;
  camera.intrinsics = CameraIntrinsics{CameraModel::kEquidistant, 640, 480, {300, 301, 320, 240, 0, 0, 0, 0}};
  camera.intrinsics_sigma.assign(8, 0.1);
  return camera;
}

class EarlierCalibration : public ::testing::Test {
 protected:
  EarlierCalibration() {
    earlier_.verdict = Verdict::kTrusted;
    earlier_.sensors = {MakeSensor("top", {0.0, 0.0, 1.0}), MakeCamera("left", {0.2, 0.0, 0.0})};
    earlier_.sensors[0].unobservable = {
        {UnobservableDirection::Quantity::kTranslation, Eigen::Vector3d::UnitZ(), 3e-3}};
    earlier_.sensors[0].translation_observable[2] = false;
    rig_.lidars.resize(1);
    rig_.lidars[0].name = "top";
    rig_.cameras.resize(2);
    rig_.cameras[0].name = "left";
    rig_.cameras[1].name = "right";
    for (CameraConfig& camera : rig_.cameras) camera.model = CameraModel::kEquidistant;
  }
  std::string ErrorOf(const std::vector<std::string>& added) {
    try {
      added.empty() ? WithPrior(rig_, earlier_, &notes_) : WithAddedSensors(rig_, earlier_, added, &notes_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  CalibrationResult earlier_;
  Rig rig_;
  std::vector<std::string> notes_;
};

TEST_F(EarlierCalibration, SensorsStartWhereItHasThemWithABoundOfTheirSigmas) {
  rig_.lidars[0].guess = ExtrinsicGuess();
  earlier_.sensors.push_back(MakeSensor("gone", {1.0, 0.0, 0.0}));
  const Rig start = WithPrior(rig_, earlier_, &notes_);
  const ExtrinsicGuess& guess = *start.lidars[0].guess;
  EXPECT_EQ(guess.T_imu_sensor.translation, earlier_.sensors[0].calibration.T_imu_sensor.translation);
  // Two errors of sigma s that are one and the same stay s in the mean of two guesses of sqrt(2) s.
  EXPECT_TRUE(guess.sigma_translation.isApprox(std::sqrt(2.0) * kTranslationSigma));
  EXPECT_TRUE(guess.sigma_rotation.isApprox(std::sqrt(2.0) * kRotationSigma));
  EXPECT_EQ(start.lidars[0].time_offset, 0.02);
  EXPECT_FALSE(start.lidars[0].fixed);
  EXPECT_EQ(start.cameras[0].intrinsics, earlier_.sensors[1].intrinsics->parameters);
  EXPECT_FALSE(start.cameras[1].guess);
  ASSERT_EQ(notes_.size(), 2u);
  EXPECT_EQ(notes_[0].substr(0, 7), "right: ");
  EXPECT_EQ(notes_[1].substr(0, 6), "gone: ");
}

TEST_F(EarlierCalibration, ItsAxesOfTheImuStay) {
  EXPECT_FALSE(WithPrior(rig_, earlier_, &notes_).imu.accelerometer_axes) << "it does not say which";
  earlier_.alignment.emplace().of_accelerometer = {Eigen::Vector3d::UnitZ()};
  for (const Rig& start :
       {WithPrior(rig_, earlier_, &notes_), WithAddedSensors(rig_, earlier_, {"right"}, &notes_)}) {
    EXPECT_EQ(start.imu.accelerometer_axes, earlier_.alignment->of_accelerometer);
  }
}

TEST_F(EarlierCalibration, OneSensorKeepsItsSigmasAndOneWithoutGetsTheUsual) {
  earlier_.sensors = {MakeSensor("top", {0.0, 0.0, 1.0})};
  earlier_.sensors[0].sigma.rotation.setZero();
  earlier_.sensors[0].sigma.time_offset = NAN;
  const Rig start = WithPrior(rig_, earlier_, &notes_);
  EXPECT_EQ(start.lidars[0].guess->sigma_translation, kTranslationSigma);
  EXPECT_EQ(start.lidars[0].guess->sigma_rotation, ExtrinsicGuess().sigma_rotation);
  EXPECT_FALSE(start.lidars[0].time_offset) << "as of a robot's model: not known";
}

TEST_F(EarlierCalibration, FixedSensorsAreHeldWithTheirOwnSigmas) {
  rig_.lidars[0].fixed = true;
  const Rig start = WithPrior(rig_, earlier_, &notes_);
  ASSERT_TRUE(start.lidars[0].held_sigma);
  EXPECT_EQ(start.lidars[0].held_sigma->translation, kTranslationSigma);
  EXPECT_EQ(start.lidars[0].held_sigma->time_offset, 1e-4);
  EXPECT_EQ(start.cameras[0].guess->sigma_translation, kTranslationSigma) << "one guess that counts";
  const CalibrationResult held = HeldSensors(start);
  ASSERT_EQ(held.sensors.size(), 1u);
  EXPECT_EQ(held.sensors[0].name, "top");

  CalibrationResult result = earlier_;
  result.sensors[0].fixed = true;
  result.sensors[0].sigma = {};
  result.sensors[1].sigma = {};
  result.sensors[1].sigma.translation.setConstant(4e-3);
  AddSigmasOfHeld(held, &result);
  EXPECT_EQ(result.sensors[0].sigma.rotation, kRotationSigma);
  EXPECT_GT(result.sensors[1].sigma.translation.x(), std::hypot(4e-3, 1e-3));
  EXPECT_EQ(result.sensors[1].intrinsics_sigma.size(), 8u);
}

TEST_F(EarlierCalibration, AFixedSensorWithoutSigmaIsExact) {
  rig_.lidars[0].fixed = true;
  rig_.lidars[0].guess = ExtrinsicGuess();
  EXPECT_TRUE(HeldSensors(rig_).sensors.empty());
}

// A fixed camera's lens is estimated, so that its sigmas are those of this drive.
TEST_F(EarlierCalibration, TheLensOfAFixedCameraKeepsItsSigmas) {
  rig_.cameras[0].fixed = true;
  rig_.cameras[0].guess = ExtrinsicGuess();
  rig_.cameras[0].held_sigma = HeldSigma{kTranslationSigma, kRotationSigma, 0.0};
  CalibrationResult result = earlier_;
  result.sensors[1].fixed = true;
  AddSigmasOfHeld(HeldSensors(rig_), &result);
  EXPECT_EQ(result.sensors[1].sigma.rotation, kRotationSigma);
  EXPECT_EQ(result.sensors[1].intrinsics_sigma.size(), 8u);
}

TEST_F(EarlierCalibration, WhatDoesNotFitIsAnError) {
  EXPECT_EQ(ErrorOf({"right"}), "");
  EXPECT_NE(ErrorOf({"wrong"}).find("wrong"), std::string::npos);
  EXPECT_NE(ErrorOf({"left"}).find("the prior lacks right"), std::string::npos);
  EXPECT_NE(ErrorOf({"top", "left", "right"}).find("no sensor is left"), std::string::npos);
  rig_.cameras[0].model = CameraModel::kPlumbBob;
  EXPECT_NE(ErrorOf({}).find("left: the prior has it with another camera model"), std::string::npos);
  rig_.cameras[0].model = CameraModel::kEquidistant;
  earlier_.sensors[0].type = SensorResult::Type::kCamera;
  EXPECT_NE(ErrorOf({}).find("top: a LiDAR in one"), std::string::npos);
  earlier_.sensors.resize(1);
  earlier_.sensors[0].name = "other";
  EXPECT_NE(ErrorOf({}).find("no sensor of the rig file"), std::string::npos);
  earlier_.verdict = Verdict::kRefused;
  EXPECT_NE(ErrorOf({}).find("was refused"), std::string::npos);
}

TEST_F(EarlierCalibration, AllButTheAddedSensorAreHeldWithTheirOwnSigmas) {
  const Rig start = WithAddedSensors(rig_, earlier_, {"right"}, &notes_);
  EXPECT_TRUE(start.lidars[0].fixed && start.cameras[0].fixed);
  EXPECT_FALSE(start.cameras[1].fixed);
  EXPECT_FALSE(start.cameras[1].guess);
  EXPECT_EQ(start.lidars[0].guess->sigma_translation, kTranslationSigma);
  EXPECT_TRUE(IsHeldFrom(earlier_, start.cameras[0]));
  EXPECT_FALSE(IsHeldFrom(earlier_, start.cameras[1]));
}

TEST_F(EarlierCalibration, ErrorsOfHeldSensorsMoveTheAddedOneAlong) {
  earlier_.sensors[1].sigma = {Eigen::Vector3d::Constant(1e-5), Eigen::Vector3d::Constant(1e-6), 2e-4};
  CalibrationResult result = earlier_;
  for (SensorResult& sensor : result.sensors) {
    sensor.fixed = true;
    sensor.sigma = {};
    sensor.unobservable.clear();
  }
  SensorResult right = MakeCamera("right", {0.0, 0.0, 3.0});  // 2 m above the LiDAR
  right.sigma = {Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(1e-4), 3e-4};
  result.sensors.push_back(right);
  PairResult pair;
  pair.a = "top";
  pair.b = "left";
  earlier_.pairs = {pair};
  earlier_.pairs[0].sigma.translation.setConstant(4e-3);
  earlier_.pairs[0].in_use.resize(2);
  result.pairs = {pair, pair};
  result.pairs[1].b = "right";
  result.pairs[1].sigma.translation.setConstant(5e-3);
  result.pairs[1].in_use.resize(2);
  AddSigmasOfHeld(earlier_, &result);
  EXPECT_EQ(result.sensors[0].sigma.translation, kTranslationSigma);
  EXPECT_EQ(result.sensors[0].unobservable.size(), 1u);
  EXPECT_FALSE(result.sensors[0].translation_observable[2]);
  const PoseSigma& sigma = result.sensors[2].sigma;
  // Along x: own, the LiDAR's, and its pitch on an arm of 2 m; along z no rotation counts.
  EXPECT_NEAR(sigma.translation.x(), std::sqrt(1e-6 + 1e-6 + std::pow(2.0 * 2e-4, 2)), 1e-9);
  EXPECT_NEAR(sigma.translation.z(), std::hypot(1e-3, 3e-3), 1e-9);
  EXPECT_NEAR(sigma.rotation.z(), std::hypot(1e-4, 3e-4), 1e-9);
  EXPECT_NEAR(sigma.time_offset, std::hypot(3e-4, 2e-4), 1e-9) << "the camera's is the larger one";
  EXPECT_EQ(result.pairs[0].sigma.translation.x(), 4e-3);
  EXPECT_EQ(result.pairs[0].in_use.size(), 2u);
  EXPECT_TRUE(result.pairs[1].in_use.empty()) << "its sigma is put together";
  // Own, and that of the LiDAR to the other camera, which the new one may follow.
  EXPECT_NEAR(result.pairs[1].sigma.translation.x(), std::hypot(1e-3, 4e-3), 1e-6);
  EXPECT_NEAR(result.pairs[1].sigma.rotation.x(), 1e-4, 1e-9);
  EXPECT_NEAR(result.pairs[1].sigma.time_offset, 3e-4, 1e-9);
}

}  // namespace
}  // namespace mlic::earlier_calibration_test
