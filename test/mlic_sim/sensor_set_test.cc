#include "mlic_sim/sensor_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "mlic_core/common/error.h"
#include "support/source_directory.h"

namespace mlic::sim::sensor_set_test {
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

TEST(SensorSet, RingBiasHasANumberForEachRow) {
  const std::string good(kGood);
  EXPECT_EQ(LoadSensorSet(Write(good + "    ring_bias: [1, 2, 3, 4, 5]\n")).lidars[0].model.ring_bias[4],
            5.0);
  EXPECT_NE(
      ErrorOf(good + "    ring_bias: [1, 2]\n").find("'ring_bias' must have a number for each of the 5"),
      std::string::npos);
  EXPECT_NE(ErrorOf(good + "    packet_loss: 2\n").find("'packet_loss'"), std::string::npos);
}

TEST(SensorSet, ReadsWhatIsSpecialAboutTheImu) {
  const std::string good(kGood);
  const SensorSet set = LoadSensorSet(
      Write("imu:\n  gravity: 9.79\n  low_pass: {gyroscope: 0.1}\n  stamps: {jitter: 1.0e-4, doubled: 0.5}\n"
            "  vibration: [{frequency: 60, specific_force: 3}, {frequency: 75, angular_velocity: 0.1}]\n" +
            good.substr(good.find("lidars:"))));
  EXPECT_EQ(set.imu.gravity, 9.79);
  EXPECT_EQ(set.imu.gyroscope_low_pass, 0.1);
  EXPECT_EQ(set.imu.accelerometer_low_pass, 0.0);
  EXPECT_EQ(set.imu.stamp_jitter, 1e-4);
  EXPECT_EQ(set.imu.doubled, 0.5);
  ASSERT_EQ(set.imu.vibration.size(), 2u);
  EXPECT_EQ(set.imu.vibration[0].specific_force, 3.0);
  EXPECT_EQ(set.imu.vibration[1].frequency, 75.0);
  EXPECT_NE(ErrorOf("imu:\n  low_pass: {gyroscope: 0.6}\n" + good.substr(good.find("lidars:")))
                .find(":2: a cut-off is a share of the rate"),
            std::string::npos);
}

TEST(SensorSet, SaysHowTheInfraredLooks) {
  EXPECT_EQ(LoadSensorSet(Write(kGood)).infrared, InfraredLook::kRelated);
  const std::string inverted = "world: {infrared: inverted_half}\n";
  EXPECT_EQ(LoadSensorSet(Write(inverted + kGood)).infrared, InfraredLook::kInvertedHalf);
  EXPECT_NE(ErrorOf("world: {infrared: odd}\n" + std::string(kGood)).find(":1: 'world.infrared' is 'odd'"),
            std::string::npos);
}

TEST(SensorSet, ErrorsNameLineAndKey) {
  EXPECT_NE(ErrorOf(std::string(kGood) + "    colour: red\n").find(":10: unknown key 'colour'"),
            std::string::npos);
  std::string organised = kGood;
  organised.replace(organised.find("hesai"), 5, "ouster");
  EXPECT_NE(ErrorOf(organised).find("needs a spinning pattern"), std::string::npos);
  EXPECT_NE(ErrorOf("imu: {rate: -1}\nlidars: {}\n").find("imu.rate"), std::string::npos);
  EXPECT_NE(ErrorOf("imu: {rate: fast}\nlidars: {}\n").find(":1: 'imu.rate'"), std::string::npos);
  EXPECT_NE(ErrorOf("imu: [\n").find("not valid YAML"), std::string::npos);
  EXPECT_THROW(LoadSensorSet("/no/such/file.yaml"), InputError);
  std::string wrong = kGood;
  wrong.replace(wrong.find("hesai"), 5, "hexagon");
  EXPECT_NE(ErrorOf(wrong).find("expected one of velodyne"), std::string::npos);
}

const char kCamera[] =
    "imu: {}\ncameras:\n  eye:\n    T_imu_sensor: {xyz: [1, 2, 3]}\n    model: equidistant\n"
    "    image_size: [640, 480]\n    intrinsics: [200, 201, 320, 240, 0.1, 0, 0, 0]\n    fov_deg: 150\n"
    "    encoding: jpeg\n";

TEST(SensorSet, ReadsCameras) {
  const SensorSet set =
      LoadSensorSet(Write(kCamera + std::string("    shutter: rolling\n    readout: 0.02\n")));
  ASSERT_EQ(set.cameras.size(), 1u);
  EXPECT_TRUE(set.lidars.empty());
  const SimulatedCamera& camera = set.cameras[0];
  EXPECT_EQ(camera.topic, "/eye/image_raw");
  EXPECT_EQ(camera.intrinsics.width, 640);
  EXPECT_EQ(camera.intrinsics.parameters[1], 201.0);
  EXPECT_TRUE(camera.rolling_shutter);
  EXPECT_EQ(camera.encoding, ImageEncoding::kJpeg);
}

TEST(SensorSet, ErrorsOfCamerasNameLineAndKey) {
  const std::string good = kCamera;
  EXPECT_NE(ErrorOf(good + "    readout: 0.02\n").find("'readout'"), std::string::npos);
  EXPECT_NE(ErrorOf(good + "    lens: wide\n").find(":10: unknown key 'lens'"), std::string::npos);
  EXPECT_NE(ErrorOf(good + "    exposure: 0.5\n").find(":10: 'exposure'"), std::string::npos);
  std::string short_list = good;
  short_list.replace(short_list.find(", 0, 0, 0]"), 10, "]");
  EXPECT_NE(ErrorOf(short_list).find(":7: 'cameras.eye.intrinsics' must have 8 numbers"), std::string::npos);
  std::string lacking = good;
  lacking.replace(lacking.find("    fov_deg: 150\n"), 17, "");
  EXPECT_NE(ErrorOf(lacking).find("lacks the key 'fov_deg'"), std::string::npos);
  EXPECT_NE(ErrorOf("imu: {}\n").find("no sensor"), std::string::npos);
}

// The angle between what the left and the right end of the middle row see, deg.
double HorizontalView(const CameraIntrinsics& intrinsics) {
  const double row = intrinsics.parameters[3];
  Eigen::Vector3d left, right, middle;
  EXPECT_TRUE(Unproject(intrinsics, {-0.5, row}, &left));
  EXPECT_TRUE(Unproject(intrinsics, {intrinsics.width - 0.5, row}, &right));
  EXPECT_TRUE(Unproject(intrinsics, {0.5 * intrinsics.width, row}, &middle));
  return (std::acos(left.dot(middle)) + std::acos(right.dot(middle))) * 180 / M_PI;
}

TEST(SensorSet, EveryShippedFileLoads) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(SourceDirectory()) / "config" / "simulation")) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path().string());
    const SensorSet set = LoadSensorSet(entry.path());
    EXPECT_GT(set.imu.noise.gyroscope, 0.0);
    EXPECT_TRUE(set.imu.calibration.gyroscope_matrix.isLowerTriangular());
    for (const SimulatedCamera& camera : set.cameras) {
      SCOPED_TRACE(camera.name);
      // The double sphere of the set has an image circle within its image.
      if (camera.intrinsics.model == CameraModel::kDoubleSphere) continue;
      EXPECT_NEAR(HorizontalView(camera.intrinsics), camera.fov_deg, 0.05 * camera.fov_deg);
      Eigen::Vector3d corner;
      EXPECT_TRUE(camera.fov_deg > 150 || Unproject(camera.intrinsics, {0, 0}, &corner));
    }
    ++count;
  }
  EXPECT_GE(count, 10);
}

// Where the middle of a LiDAR's field of view looks, in the IMU's frame.
Eigen::Vector3d Boresight(const SimulatedLidar& lidar) {
  return lidar.calibration.T_imu_sensor.rotation * (lidar.model.R_sensor_pattern * Eigen::Vector3d::UnitX());
}

TEST(SensorSet, PaperRigLooksOutwardAndDown) {
  const SensorSet set =
      LoadSensorSet(fs::path(SourceDirectory()) / "config/simulation/paper_rig_lidars.yaml");
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
}  // namespace mlic::sim::sensor_set_test
