#include "mlic_core/io/result/velodyne_calibration.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "mlic_core/io/text_file.h"
#include "support/files.h"

namespace mlic::velodyne_calibration_test {
namespace {

// As velodyne_pointcloud's VLP-16 and HDL-64 files are written, lasers in no order of elevation.
const char* const kFile =
    "# of unit 42\n"
    "lasers:\n"
    "- {dist_correction: 0.0, dist_correction_x: 0.1, dist_correction_y: 0.2, laser_id: 0, rot_correction: "
    "0.0,\n"
    "  vert_correction: -0.2617993877991494, vert_offset_correction: 0.0}\n"
    "- {dist_correction: 1.5e-02, laser_id: 1, vert_correction: 0.1}  # replaced in May\n"
    "- laser_id: 2\n"
    "  vert_correction: -0.1\n"
    "  dist_correction: 0.02\n"
    "num_lasers: 3\n"
    "distance_resolution: 0.002\n";

class VelodyneCalibration : public testing::Test {
 protected:
  std::string Merged(const std::string& text, const PointCorrections& corrections) {
    WriteFileAtomically(path_, text);
    return WithCorrections(path_, "top", corrections);
  }
  std::string ErrorOf(const std::string& text, const PointCorrections& corrections) {
    return InputErrorOf([&] { Merged(text, corrections); });
  }

  TemporaryDirectory directory_;
  const std::filesystem::path path_ = directory_.Path() / "vlp.yaml";
};

TEST_F(VelodyneCalibration, CorrectionsAreAddedToTheLasersThatTheDriverCallsTheRings) {
  const YAML::Node file =
      YAML::Load(Merged(kFile, {0.01, 0.1, 0.0, 0.0, {{1, 0.004, 0.002}, {2, 0.0, -0.003}}}));
  const auto number = [&](int laser, const char* key) { return file["lasers"][laser][key].as<double>(); };
  const double lowest = -0.2617993877991494;
  EXPECT_NEAR(number(0, "dist_correction"), 0.01 + 0.1 * lowest, 1e-9);
  EXPECT_NEAR(number(0, "dist_correction_x"), 0.1 + 0.01 + 0.1 * lowest, 1e-9);
  EXPECT_NEAR(number(0, "dist_correction_y"), 0.2 + 0.01 + 0.1 * lowest, 1e-9);
  EXPECT_EQ(number(0, "vert_correction"), lowest);
  EXPECT_NEAR(number(2, "dist_correction"), 0.02 + 0.01 - 0.01 + 0.004, 1e-9) << "the middle ring";
  EXPECT_NEAR(number(2, "vert_correction"), -0.098, 1e-9);
  EXPECT_NEAR(number(1, "dist_correction"), 0.015 + 0.01 + 0.01, 1e-9);
  EXPECT_NEAR(number(1, "vert_correction"), 0.097, 1e-9);
}

TEST_F(VelodyneCalibration, AllElseStaysAsItIs) {
  const std::string merged = Merged(kFile, {0.0, 0.0, 0.0, 0.0, {{2, 0.0, 0.05}}});
  std::string expected = kFile;
  const std::string before = "vert_correction: 0.1}";
  expected.replace(expected.find(before), before.size(), "vert_correction: 0.150000000}");
  EXPECT_EQ(merged.substr(merged.find('\n') + 1), expected);
}

TEST_F(VelodyneCalibration, CountOnceAndOnlyInAFileThatHasTheRings) {
  const PointCorrections corrections{0.01, 0.0, 0.0, 0.0, {}};
  EXPECT_TRUE(Contains(ErrorOf(Merged(kFile, corrections), corrections), "already"));
  EXPECT_TRUE(
      Contains(ErrorOf(kFile, {0.0, 0.0, 0.0, 0.0, {{3, 0.01, 0.0}}}), "lasers: has 3 lasers, and ring 3"));
  EXPECT_TRUE(Contains(ErrorOf("rings: []\n", corrections), "key 'lasers' is missing"));
  EXPECT_TRUE(
      Contains(ErrorOf("lasers:\n- {vert_correction: 0.1}\n", corrections), "'dist_correction' is missing"));
}

}  // namespace
}  // namespace mlic::velodyne_calibration_test
