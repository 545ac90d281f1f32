#include "mlic_core/evaluation/repeatability.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "support/files.h"
#include "support/sample_result.h"

namespace mlic::repeatability_test {
namespace {

// The sample with errors of the claimed sigmas times `factor`; pairs follow their sensors.
CalibrationResult Drawn(std::uint64_t seed, double factor) {
  CalibrationResult result = SampleResult();
  result.alignment.reset();
  Random random(seed);
  const auto draw = [&](const Eigen::Vector3d& sigma) {
    return Eigen::Vector3d(factor * random.Normal() * sigma.x(), factor * random.Normal() * sigma.y(),
                           factor * random.Normal() * sigma.z());
  };
  for (SensorResult& sensor : result.sensors) {
    RigidTransform& T = sensor.calibration.T_imu_sensor;
    T.rotation = ExpQuaternion(draw(sensor.sigma.rotation)) * T.rotation;
    T.translation += draw(sensor.sigma.translation);
    sensor.calibration.time_offset += factor * random.Normal() * sensor.sigma.time_offset;
  }
  result.pairs.clear();
  for (std::size_t b = 1; b < result.sensors.size(); ++b) {
    const SensorResult &first = result.sensors[0], &second = result.sensors[b];
    PairResult pair;
    pair.a = first.name;
    pair.b = second.name;
    pair.T_a_b = first.calibration.T_imu_sensor.Inverse() * second.calibration.T_imu_sensor;
    result.pairs.push_back(pair);
  }
  return result;
}

PoseSpread Named(const Repeatability& found, const std::string& name) {
  for (const PoseSpread& pose : found.poses) {
    if (pose.name == name) return pose;
  }
  throw std::runtime_error("no pose " + name);
}

// As those of other methods: their pairs follow from their sensors.
TEST(Repeatability, PairsNeedNotBeListed) {
  std::vector<CalibrationResult> listed{Drawn(1, 1.0), Drawn(2, 1.0)}, bare = listed;
  for (CalibrationResult& calibration : bare) calibration.pairs.clear();
  const std::string name = listed[0].pairs[0].a + "/" + listed[0].pairs[0].b;
  const PoseSpread expected = Named(MeasureRepeatability(listed, nullptr), name);
  const PoseSpread found = Named(MeasureRepeatability(bare, nullptr), name);
  EXPECT_GT(expected.translation_spread.norm(), 1e-5);
  EXPECT_LT((found.translation_spread - expected.translation_spread).norm(), 1e-12);
  EXPECT_LT((found.rotation_spread - expected.rotation_spread).norm(), 1e-12);
}

TEST(Repeatability, SpreadAndErrorsAreThoseThatWereDrawn) {
  std::vector<CalibrationResult> calibrations;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) calibrations.push_back(Drawn(seed, 1.0));
  const CalibrationResult truth = Drawn(1, 0.0);
  const SensorResult& sensor = truth.sensors[0];
  for (const CalibrationResult* against : {&truth, static_cast<const CalibrationResult*>(nullptr)}) {
    const PoseSpread pose = Named(MeasureRepeatability(calibrations, against), sensor.name);
    EXPECT_EQ(pose.kind, "lidar-imu");
    EXPECT_EQ(pose.count, 400);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(pose.translation_spread[k] / sensor.sigma.translation[k], 1.0, 0.12);
      EXPECT_NEAR(pose.rotation_spread[k] / sensor.sigma.rotation[k], 1.0, 0.12);
    }
    EXPECT_NEAR(pose.translation_rmse.norm() / sensor.sigma.translation.norm(), 1.0, 0.12);
    EXPECT_NEAR(pose.rotation_rmse.norm() / sensor.sigma.rotation.norm(), 1.0, 0.12);
    const double off = (pose.mean.translation - sensor.calibration.T_imu_sensor.translation).norm();
    EXPECT_LT(off, 4.0 * sensor.sigma.translation.norm() / 20.0);
    EXPECT_LT(AngleBetween(pose.mean.rotation, sensor.calibration.T_imu_sensor.rotation),
              4.0 * sensor.sigma.rotation.norm() / 20.0);
  }
}

TEST(Repeatability, ConcludesByTheClaims) {
  std::vector<CalibrationResult> calibrations;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) calibrations.push_back(Drawn(seed, 1.0));
  const CalibrationResult truth = Drawn(1, 0.0);
  EXPECT_TRUE(
      Contains(TableOf(MeasureRepeatability(calibrations, &truth)), "\nerrors agree with the claims"));
  EXPECT_TRUE(
      Contains(TableOf(MeasureRepeatability(calibrations, nullptr)), "\nerrors agree with the claims"));
  calibrations[3].sensors[1].calibration.T_imu_sensor.translation.z() +=
      12.0 * calibrations[3].sensors[1].sigma.translation.z();
  for (const CalibrationResult* against : {&truth, static_cast<const CalibrationResult*>(nullptr)}) {
    EXPECT_TRUE(Contains(TableOf(MeasureRepeatability(calibrations, against)),
                         "\nERRORS EXCEED THE CLAIMS: worst 1"));
    EXPECT_TRUE(Contains(TableOf(MeasureRepeatability(calibrations, against)),
                         calibrations[3].sensors[1].name + ", translation z"));
  }
}

// Of two calibrations each is half of the mean: their difference is sqrt(2) sigmas of one.
TEST(Repeatability, CountsThatACalibrationIsPartOfTheMean) {
  std::vector<CalibrationResult> calibrations{Drawn(1, 0.0), Drawn(1, 0.0)};
  const double sigma = calibrations[0].sensors[0].sigma.translation.x();
  calibrations[1].sensors[0].calibration.T_imu_sensor.translation.x() += 6.0 * std::sqrt(2.0) * sigma;
  const Repeatability found = MeasureRepeatability(calibrations, nullptr);
  EXPECT_NEAR(found.worst.sigmas, 6.0, 1e-6);
  EXPECT_NEAR(Named(found, calibrations[0].sensors[0].name).translation_rmse.x(), 6.0 * sigma, 1e-9);
}

TEST(Repeatability, NeedsMoreThanOneCalibration) {
  EXPECT_TRUE(Contains(InputErrorOf([] { MeasureRepeatability({SampleResult()}, nullptr); }),
                       "says nothing of its errors"));
  CalibrationResult other = SampleResult();
  for (SensorResult& sensor : other.sensors) sensor.name += "_other";
  other.pairs.clear();
  const CalibrationResult truth = SampleResult();
  EXPECT_TRUE(Contains(InputErrorOf([&] { MeasureRepeatability({other}, &truth); }), "no sensor in common"));
}

}  // namespace
}  // namespace mlic::repeatability_test
