#include "mlic_core/io/result/correction_files.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>

#include "mlic_core/association/ring_corrections.h"
#include "support/sample_result.h"

namespace mlic::correction_files_test {
namespace {

// A laser as velodyne_pointcloud computes its points, but for what is zero in its files of most models.
Eigen::Vector3d VelodynePoint(double distance, double azimuth, double dist_correction,
                              double vert_correction) {
  const double range = distance + dist_correction;
  const double in_plane = range * std::cos(vert_correction);
  return {in_plane * std::cos(azimuth), -in_plane * std::sin(azimuth), range * std::sin(vert_correction)};
}

// The driver with the file's numbers in its calibration gives the points that the calibration holds for.
TEST(CorrectionFiles, MeanWhatTheDriverDoes) {
  CalibrationResult result = SampleResult();
  SensorResult& lidar = result.sensors[0];
  lidar.corrections = {0.012, -0.03, 0.015, 40.0, {{3, 0.004, -0.0007}, {11, -0.006, 0.0011}}};
  const std::vector<ExportedFile> files = CorrectionFiles(result);
  ASSERT_EQ(files.size(), 1u) << "of the LiDAR that was corrected";
  EXPECT_EQ(files[0].name, lidar.name + ".yaml");
  const YAML::Node file = YAML::Load(files[0].text);
  CalibrationState state;
  state.rings.resize(1);
  state.rings[0].resize(12);
  state.rings[0][3] = {0.004f, -0.0007f};
  state.rings[0][11] = {-0.006f, 0.0011f};
  state.ranges = {{0.012, -0.03, 0.015, 40.0}};
  ASSERT_EQ(file["rings"].size(), 2u);
  for (const YAML::Node& ring : file["rings"]) {
    LidarPoint point;
    point.ring = ring["ring"].as<std::uint16_t>();
    point.intensity = 90.0f;
    const double vertical = -0.2 + 0.03 * point.ring, distance = 14.0, azimuth = 0.7;
    point.position = VelodynePoint(distance, azimuth, 0.0, vertical).cast<float>();
    const double added = file["range_offset"].as<double>() + file["range_slope"].as<double>() * vertical +
                         ring["range"].as<double>() +
                         file["range_walk"].as<double>() *
                             std::log10(point.intensity / file["reference_intensity"].as<double>());
    const Eigen::Vector3d driver =
        VelodynePoint(distance, azimuth, added, vertical + ring["elevation"].as<double>());
    EXPECT_LT((driver - CorrectedPoint(point, state, 0).cast<double>()).norm(), 2e-5);
  }
}

TEST(CorrectionFiles, AreOfCorrectedLidarsOnly) { EXPECT_TRUE(CorrectionFiles(SampleResult()).empty()); }

}  // namespace
}  // namespace mlic::correction_files_test
