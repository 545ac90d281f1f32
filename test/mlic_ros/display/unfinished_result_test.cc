#include "mlic_ros/display/unfinished_result.h"

#include <gtest/gtest.h>

#include "mlic_core/io/result/result_file.h"

namespace mlic::unfinished_result_test {
namespace {

TEST(UnfinishedResult, IsReadBackAsRefusedWithTheStateAsItWas) {
  CalibrationSnapshot snapshot;
  snapshot.stage = "joint adjustment";
  snapshot.iteration = 2;
  snapshot.sensor_names = {"lidar"};
  snapshot.sensor_frames = {"velodyne"};
  snapshot.sensors.resize(1);
  snapshot.sensors[0].time_offset = 0.03;
  snapshot.sensors[0].T_imu_sensor.translation.x() = 1.5;
  const std::filesystem::path directory =
      std::filesystem::path(testing::TempDir()) / "unfinished_result_test";
  WriteUnfinished(directory, UnfinishedResult(snapshot, "imu_link"));
  const CalibrationResult read = ReadCalibrationFile(directory / "calibration.yaml");
  std::filesystem::remove_all(directory);
  EXPECT_FALSE(read.Usable());
  ASSERT_EQ(read.reasons.size(), 1u);
  EXPECT_NE(read.reasons[0].find("unfinished: the state after round 3 of joint adjustment"),
            std::string::npos);
  ASSERT_EQ(read.sensors.size(), 1u);
  EXPECT_EQ(read.sensors[0].calibration.T_imu_sensor.translation.x(), 1.5);
  EXPECT_EQ(read.sensors[0].calibration.time_offset, 0.03);
}

}  // namespace
}  // namespace mlic::unfinished_result_test
