#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/sensor_set.h"

namespace mlic::sim {
namespace {

namespace fs = std::filesystem;

fs::path Write(const std::string& text) {
  const fs::path path = fs::path(testing::TempDir()) / "sensors.yaml";
  std::ofstream(path) << text;
  return path;
}

std::string ErrorOf(const std::string& text) {
  try {
    LoadSensorSet(Write(text));
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

const char kGood[] =
    "imu:\n  rate: 100\n  gyroscope_matrix: [1, 2, 3, 4, 5, 6, 7, 8, 9]\nlidars:\n  top:\n"
    "    T_imu_sensor: {xyz: [1, 2, 3], rpy_deg: [0, 0, 90]}\n    time_offset: 0.01\n    layout: hesai\n"
    "    pattern: {kind: raster, columns: 10, rows: 5}\n";

TEST(SensorSet, ReadsItsKeys) {
  const SensorSet set = LoadSensorSet(Write(kGood));
  EXPECT_EQ(set.imu.rate, 100.0);
  EXPECT_EQ(set.imu.calibration.gyroscope_matrix(0, 1), 2.0);
  ASSERT_EQ(set.lidars.size(), 1u);
  EXPECT_EQ(set.lidars[0].topic, "/top/points");
  EXPECT_EQ(set.lidars[0].layout, PointLayout::kHesai);
  EXPECT_EQ(set.lidars[0].model.columns, 10);
  EXPECT_LT(
      (set.lidars[0].calibration.T_imu_sensor * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(),
      1e-12);
}

TEST(SensorSet, ErrorsNameLineAndKey) {
  EXPECT_NE(ErrorOf(std::string(kGood) + "    colour: red\n").find(":10: unknown key 'colour'"),
            std::string::npos);
  std::string organised = kGood;
  organised.replace(organised.find("hesai"), 5, "ouster");
  EXPECT_NE(ErrorOf(organised).find("needs a spinning pattern"), std::string::npos);
  EXPECT_NE(ErrorOf("imu: {}\n").find("'lidars'"), std::string::npos);
  EXPECT_NE(ErrorOf("imu: {rate: -1}\nlidars: {}\n").find("imu.rate"), std::string::npos);
  EXPECT_NE(ErrorOf("imu: {rate: fast}\nlidars: {}\n").find(":1: 'imu.rate'"), std::string::npos);
  EXPECT_NE(ErrorOf("imu: [\n").find("not valid YAML"), std::string::npos);
  EXPECT_THROW(LoadSensorSet("/no/such/file.yaml"), InputError);
  std::string wrong = kGood;
  wrong.replace(wrong.find("hesai"), 5, "hexagon");
  EXPECT_NE(ErrorOf(wrong).find("expected one of velodyne"), std::string::npos);
}

TEST(SensorSet, EveryShippedFileLoads) {
  int count = 0;
  for (const auto& entry :
       fs::directory_iterator(fs::path(MLIC_SOURCE_DIRECTORY) / "config" / "simulation")) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path().string());
    const SensorSet set = LoadSensorSet(entry.path());
    EXPECT_GT(set.imu.noise.gyroscope, 0.0);
    EXPECT_TRUE(set.imu.calibration.accelerometer_matrix.isLowerTriangular());
    ++count;
  }
  EXPECT_GE(count, 5);
}

// Where the middle of a LiDAR's field of view looks, in the IMU's frame.
Eigen::Vector3d Boresight(const SimulatedLidar& lidar) {
  return lidar.calibration.T_imu_sensor.rotation * (lidar.model.R_sensor_pattern * Eigen::Vector3d::UnitX());
}

TEST(SensorSet, PaperRigLooksOutwardAndDown) {
  const SensorSet set = LoadSensorSet(fs::path(MLIC_SOURCE_DIRECTORY) / "config/simulation/paper_rig_lidars.yaml");
  ASSERT_EQ(set.lidars.size(), 4u);
  const Eigen::Vector3d outward[] = {{0, 1, 0}, {0, -1, 0}, {-1, 0, 0}, {1, 0, 0}};
  for (int i = 0; i < 4; ++i) {
    SCOPED_TRACE(set.lidars[i].name);
    const Eigen::Vector3d direction = Boresight(set.lidars[i]);
    EXPECT_GT(direction.dot(outward[i]), 0.98);
    EXPECT_LT(direction.z(), -0.05);
    // The pattern's z axis points up.
    EXPECT_GT((set.lidars[i].calibration.T_imu_sensor.rotation *
               (set.lidars[i].model.R_sensor_pattern * Eigen::Vector3d::UnitZ()))
                  .z(),
              0.98);
    EXPECT_LT(std::abs(set.lidars[i].calibration.time_offset), 0.03);
  }
}

}  // namespace
}  // namespace mlic::sim
