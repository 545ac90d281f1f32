#include "mlic_core/evaluation/calibration_difference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/sample_result.h"

namespace mlic::calibration_difference_test {
namespace {

TEST(CalibrationDifference, OfItselfIsNothing) {
  const CalibrationResult a = SampleResult();
  const CalibrationDifference difference = Subtract(a, a);
  EXPECT_EQ(difference.poses.sensors.size(), a.sensors.size());
  EXPECT_EQ(difference.poses.pairs.size(), a.pairs.size());
  EXPECT_FALSE(difference.intrinsics.empty());
  EXPECT_LT(LargestOf(difference).sigmas, 1e-6);
  EXPECT_FALSE(LargestOf(difference).of.empty());
}

TEST(CalibrationDifference, CountsTheSigmasOfBoth) {
  CalibrationResult a = SampleResult();
  a.sensors.resize(2);
  a.pairs.clear();
  CalibrationResult b = a;
  const double sigma = a.sensors[1].sigma.translation.y();
  b.sensors[1].calibration.T_imu_sensor.translation.y() += 10.0 * sigma;
  b.sensors[1].sigma.translation.y() = 3.0 * sigma;
  const LargestDifference largest = LargestOf(Subtract(a, b));
  EXPECT_EQ(largest.of, a.sensors[1].name + ", translation y");
  EXPECT_NEAR(largest.sigmas, std::sqrt(10.0), 1e-9);
}

TEST(CalibrationDifference, IntrinsicsCountToo) {
  const CalibrationResult a = SampleResult();
  CalibrationResult b = a;
  SensorResult& camera = b.sensors.back();
  ASSERT_TRUE(camera.intrinsics);
  ASSERT_FALSE(camera.intrinsics_sigma.empty());
  camera.intrinsics->parameters[0] -= 20.0 * camera.intrinsics_sigma[0];
  const CalibrationDifference difference = Subtract(a, b);
  EXPECT_EQ(LargestOf(difference).of, camera.name + ", fx");
  EXPECT_NEAR(LargestOf(difference).sigmas, 20.0 / std::sqrt(2.0), 1e-9);
  EXPECT_NE(TableOf(difference).find(camera.name + " fx: "), std::string::npos);
}

TEST(CalibrationDifference, NamesSensorsThatOnlyOneHas) {
  const CalibrationResult a = SampleResult();
  CalibrationResult b = a;
  b.sensors.pop_back();
  const std::string name = a.sensors.back().name;
  EXPECT_EQ(Subtract(a, b).only_in_a, std::vector<std::string>{name});
  EXPECT_EQ(Subtract(b, a).only_in_b, std::vector<std::string>{name});
  EXPECT_NE(TableOf(Subtract(b, a)).find(name + ": only in B"), std::string::npos);
}

}  // namespace
}  // namespace mlic::calibration_difference_test
