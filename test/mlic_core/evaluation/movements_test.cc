#include "mlic_core/evaluation/movements.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/geometry/so3.h"

namespace mlic::movements_test {
namespace {

constexpr double kLimit = 5.0;  // sigmas

SensorResult Sensor(const std::string& name, const Eigen::Vector3d& position, const Eigen::Vector3d& rpy) {
  SensorResult sensor;
  sensor.name = name;
  sensor.calibration.T_imu_sensor = {FromRollPitchYaw(rpy), position};
  sensor.calibration.time_offset = 0.01;
  sensor.sigma = {Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(1e-4), 1e-4};
  return sensor;
}

void MakePairs(CalibrationResult* result) {
  result->pairs.clear();
  for (std::size_t a = 0; a < result->sensors.size(); ++a) {
    for (std::size_t b = a + 1; b < result->sensors.size(); ++b) {
      const SensorResult &first = result->sensors[a], &second = result->sensors[b];
      result->pairs.push_back({first.name,
                               second.name,
                               first.calibration.T_imu_sensor.Inverse() * second.calibration.T_imu_sensor,
                               {Eigen::Vector3d::Constant(5e-4), Eigen::Vector3d::Constant(5e-5), 1e-4}});
    }
  }
}

CalibrationResult Three() {
  CalibrationResult result;
  result.sensors = {Sensor("left", {0.1, 1.0, 0.3}, {0.1, -0.2, 1.5}),
                    Sensor("right", {0.2, -1.0, 0.3}, {0.0, 0.2, -1.5}),
                    Sensor("camera", {0.5, 0.1, 0.2}, {-1.5, 0.0, -1.5})};
  MakePairs(&result);
  return result;
}

CalibrationResult WithMoved(std::size_t sensor, const RigidTransform& by) {
  CalibrationResult moved = Three();
  RigidTransform& T = moved.sensors[sensor].calibration.T_imu_sensor;
  T = T * by;
  MakePairs(&moved);
  return moved;
}

std::vector<std::string> Moved(const Movements& movements) {
  std::vector<std::string> names;
  if (movements.imu_moved) names.emplace_back(kImuBody);
  for (const BodyMovement& body : movements.sensors) {
    if (body.Moved()) names.push_back(body.name);
  }
  return names;
}

using Names = std::vector<std::string>;

TEST(Movements, OfACalibrationAndItselfAreNone) {
  const Movements movements = FindMovements(Three(), Three(), kLimit);
  ASSERT_EQ(movements.sensors.size(), 3u);
  EXPECT_EQ(Moved(movements), Names());
  EXPECT_EQ(WhatMoved(movements), "");
  EXPECT_LT(movements.worst, 1e-6);
  // The pair tells more than the relation to the IMU, and half a millimetre of both is shown to this.
  EXPECT_EQ(movements.sensors[0].against, "right");
  EXPECT_NEAR(movements.sensors[0].translation.shown, kLimit * 5e-4 * std::sqrt(2.0), 1e-12);
  EXPECT_TRUE(movements.sensors[0].translation.not_checked.empty());
}

TEST(Movements, NameTheSensorAndNoOther) {
  const RigidTransform by{FromRollPitchYaw({0.0, 0.002, 0.0}), Eigen::Vector3d(0.0, 0.0, 0.01)};
  for (std::size_t sensor = 0; sensor < 3; ++sensor) {
    const Movements movements = FindMovements(WithMoved(sensor, by), Three(), kLimit);
    EXPECT_EQ(Moved(movements), Names{Three().sensors[sensor].name});
    EXPECT_TRUE(movements.or_instead.empty());
    EXPECT_NEAR(movements.sensors[sensor].rotation.value, 0.002, 1e-9);
    EXPECT_NEAR(movements.sensors[sensor].translation.value, 0.01, 1e-9);
    EXPECT_NE(WhatMoved(movements).find(Three().sensors[sensor].name + " by 0.115 deg"), std::string::npos);
  }
}

TEST(Movements, AreToldByPairsWhereTheImuTellsThemNot) {
  CalibrationResult calibration = Three();
  CalibrationResult check = WithMoved(0, {Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, 0.0, 0.01)});
  for (CalibrationResult* result : {&calibration, &check}) {
    for (SensorResult& sensor : result->sensors) sensor.sigma.translation.setConstant(0.1);
  }
  const Movements movements = FindMovements(check, calibration, kLimit);
  EXPECT_EQ(Moved(movements), Names{"left"});
  EXPECT_TRUE(movements.sensors[0].translation.told);
}

TEST(Movements, NameTheImuWhereAllSensorsMovedAlike) {
  CalibrationResult check = Three();
  const RigidTransform by{FromRollPitchYaw({0.001, 0.0, 0.003}), Eigen::Vector3d(0.0, 0.01, 0.0)};
  for (SensorResult& sensor : check.sensors) {
    sensor.calibration.T_imu_sensor = by * sensor.calibration.T_imu_sensor;
    sensor.calibration.time_offset += 0.002;
  }
  MakePairs(&check);
  const Movements movements = FindMovements(check, Three(), kLimit);
  EXPECT_EQ(Moved(movements), Names{kImuBody});
  EXPECT_TRUE(movements.imu_clock_shifted);
  EXPECT_FALSE(movements.sensors[0].clock.told);
}

TEST(Movements, OfASensorAloneMayBeTheImus) {
  CalibrationResult calibration = Three(), check = WithMoved(0, {FromRollPitchYaw({0.0, 0.0, 0.01}), {}});
  for (CalibrationResult* result : {&calibration, &check}) {
    result->sensors.resize(1);
    result->pairs.clear();
  }
  const Movements movements = FindMovements(check, calibration, kLimit);
  EXPECT_EQ(Moved(movements), Names{"left"});
  EXPECT_EQ(movements.or_instead, Names{kImuBody});
}

TEST(Movements, OfAClockAreNoneOfTheMount) {
  CalibrationResult check = Three();
  check.sensors[1].calibration.time_offset -= 0.003;
  const Movements movements = FindMovements(check, Three(), kLimit);
  EXPECT_EQ(Moved(movements), Names());
  EXPECT_TRUE(movements.sensors[1].clock.told);
  EXPECT_FALSE(movements.sensors[0].clock.told);
  EXPECT_NEAR(movements.sensors[1].clock.value, -0.003, 1e-12);
  // A clock that drifts has another offset in every drive.
  CalibrationResult drifting = Three();
  drifting.sensors[1].calibration.clock_drift = 1e-5;
  EXPECT_FALSE(FindMovements(check, drifting, kLimit).sensors[1].clock.told);
}

// As of a robot's model, which has poses alone.
TEST(Movements, OfOffsetsThatAreNotKnownAreNone) {
  CalibrationResult model = WithMoved(2, {FromRollPitchYaw({0.0, 0.0, 0.01}), Eigen::Vector3d::Zero()});
  for (SensorResult& sensor : model.sensors) {
    sensor.sigma = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), NAN};
    sensor.calibration.time_offset = 0.0;
  }
  for (PairResult& pair : model.pairs) pair.sigma = model.sensors[0].sigma;
  const Movements movements = FindMovements(Three(), model, kLimit);
  EXPECT_EQ(Moved(movements), Names{"camera"});
  for (const BodyMovement& body : movements.sensors) {
    EXPECT_FALSE(body.clock.told);
    EXPECT_TRUE(std::isnan(body.clock.sigmas));
    EXPECT_FALSE(std::isnan(body.rotation.sigmas));
  }
}

TEST(Movements, SayWhatIsNotChecked) {
  CalibrationResult calibration = Three(), check = Three();
  for (CalibrationResult* result : {&calibration, &check}) result->pairs.clear();
  check.sensors[0].sigma.translation.z() = 0.1;
  check.sensors.pop_back();
  const Movements movements = FindMovements(check, calibration, kLimit);
  ASSERT_EQ(movements.sensors.size(), 2u);
  EXPECT_EQ(movements.sensors[0].translation.not_checked, Names{"z"});
  EXPECT_NE(TableOf(movements).find("agrees; not checked: translation z"), std::string::npos);
  EXPECT_NE(CsvOf(movements).find("left,imu,0,0,"), std::string::npos);
}

}  // namespace
}  // namespace mlic::movements_test
