#include "mlic_core/summary/warnings.h"

#include <gtest/gtest.h>

#include "mlic_core/sensors/rig.h"

namespace mlic::warnings_test {
namespace {

SensorResult Camera(double offset_sigma) {
  SensorResult camera;
  camera.name = "front";
  camera.type = SensorResult::Type::kCamera;
  camera.sigma.time_offset = offset_sigma;
  return camera;
}

TEST(Warnings, AreGivenOfStampsWhoseWanderIsMostOfTheOffsetsSigma) {
  std::vector<std::string> warnings;
  WarnOfWander(Camera(17e-6), 1e-10, &warnings);  // 10 us of 17
  EXPECT_TRUE(warnings.empty());
  WarnOfWander(Camera(0.26e-3), 0.0625e-6, &warnings);  // 0.25 ms of 0.26
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("front: its stamps wander by 0.25 ms"), std::string::npos) << warnings[0];
  WarnOfWander(Camera(1e-3), 0.0, &warnings);
  EXPECT_EQ(warnings.size(), 1u);
}

// As of kitti_0005's navigation system; a raw IMU's filters delay by milliseconds.
TEST(Warnings, AreGivenOfAnAccelerometerBehindItsGyroscope) {
  std::vector<std::string> warnings;
  WarnOfLag(4e-3, 1e-4, &warnings);
  WarnOfLag(-30e-3, 10e-3, &warnings);
  EXPECT_TRUE(warnings.empty());
  WarnOfLag(47e-3, 2e-3, &warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("accelerometer is 47 ms later than its gyroscope (sigma 2.0 ms)"),
            std::string::npos)
      << warnings[0];
}

TEST(Warnings, AreGivenOfClocksThatDriftByMoreThanThreeSigmas) {
  SensorResult camera = Camera(1e-4);
  std::vector<std::string> warnings;
  WarnOfDrift(camera, &warnings);
  camera.drift_sigma = 5e-6;
  camera.calibration.clock_drift = 14e-6;
  WarnOfDrift(camera, &warnings);
  EXPECT_TRUE(warnings.empty());
  camera.calibration.clock_drift = 20e-6;
  WarnOfDrift(camera, &warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("20.0 ppm"), std::string::npos) << warnings[0];
  camera.calibration.clock_drift = 2.0 * kFastestCrystals;
  WarnOfDrift(camera, &warnings);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[1].find("auto exposure"), std::string::npos) << warnings[1];
}

}  // namespace
}  // namespace mlic::warnings_test
