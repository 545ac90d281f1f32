#include "mlic_core/io/report/report_data.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/report/report.h"
#include "mlic_core/io/report/report_verdict.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/sample_result.h"

namespace mlic::report_data_test {
namespace {

// JSON is YAML: what stands between the script element's tags.
YAML::Node DataOf(const std::string& html) {
  const std::string open = "<script type=\"application/json\" id=\"calibration\">";
  const std::size_t begin = html.find(open) + open.size();
  return YAML::Load(html.substr(begin, html.find("</script>", begin) - begin));
}

void ExpectSame(const YAML::Node& a, const YAML::Node& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].as<double>(), b[i].as<double>()) << what;
}

TEST(ReportData, HoldsTheNumbersOfTheCalibrationFile) {
  TemporaryDirectory directory;
  const CalibrationResult result = SampleResult();
  WriteReport(directory.Path() / "report.html", result, "/data");
  WriteCalibrationFile(directory.Path() / "calibration.yaml", result);
  const YAML::Node data = DataOf(ReadFile(directory.Path() / "report.html"));
  const YAML::Node file = YAML::LoadFile(directory.Path() / "calibration.yaml");
  EXPECT_EQ(data["root"].as<std::string>(), "imu_link");
  ASSERT_EQ(data["sensors"].size(), file["sensors"].size());
  for (const YAML::Node& sensor : data["sensors"]) {
    const auto name = sensor["name"].as<std::string>();
    const YAML::Node written = file["sensors"][name];
    EXPECT_EQ(sensor["type"].as<std::string>(), written["type"].as<std::string>());
    for (const char* key : {"translation", "rotation"}) {
      ExpectSame(sensor["T_root_sensor"][key], written["T_imu_sensor"][key], name);
    }
    for (const char* key : {"translation", "rotation_deg"}) {
      ExpectSame(sensor["sigma"][key], written["sigma"][key], name);
    }
    EXPECT_EQ(sensor["time_offset"].as<double>(), written["time_offset"].as<double>());
  }
  for (const YAML::Node& pair : data["pairs"]) {
    const std::string name = pair["a"].as<std::string>() + "/" + pair["b"].as<std::string>();
    ExpectSame(pair["sigma"]["translation"], file["pairs"][name]["sigma"]["translation"], name);
  }
  EXPECT_EQ(data["pairs"].size(), file["pairs"].size());
}

TEST(ReportData, FramesOfTheBagCannotEndTheScript) {
  CalibrationResult result = SampleResult();
  result.sensors[0].name = "</script><b>\"\\\n";
  const std::string text = ReportData(result, DrawingOf(result));
  EXPECT_EQ(text.find("</script"), std::string::npos);
  EXPECT_EQ(YAML::Load(text)["sensors"][0]["name"].as<std::string>(), result.sensors[0].name);
}

TEST(RigDrawing, IsSeenAlongTheWayThatTheVehicleDrives) {
  CalibrationResult result = SampleResult();
  // An IMU whose x points up and whose y points back, on a drive along the map's x.
  Eigen::Matrix3d R_map_imu;
  R_map_imu << 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0;
  result.trajectories[0].clear();
  for (int i = 0; i < 50; ++i) {
    result.trajectories[0].push_back(
        {i * 100000000LL, {Eigen::Quaterniond(R_map_imu), Eigen::Vector3d(0.5 * i, 0.0, 0.0)}});
  }
  const Eigen::Matrix3d view = DrawingOf(result).R_view_root;
  EXPECT_TRUE(view.row(0).transpose().isApprox(Eigen::Vector3d(0.0, -1.0, 0.0), 1e-9)) << view;
  EXPECT_TRUE(view.row(2).transpose().isApprox(Eigen::Vector3d(1.0, 0.0, 0.0), 1e-9)) << view;
  EXPECT_NEAR(view.determinant(), 1.0, 1e-9);
}

TEST(RigDrawing, SigmasOfWhatIsNotObservableAreAtTheirSize) {
  CalibrationResult result = SampleResult();
  for (SensorResult& sensor : result.sensors) sensor.translation_observable = {false, false, false};
  EXPECT_EQ(DrawingOf(result).ellipsoid_scale, 1.0);
  EXPECT_NE(VerdictBlock(result).find("<b>no</b><span>translation is observable"), std::string::npos);
}

TEST(RigDrawing, OfPairsStandsAboutTheirRoot) {
  CalibrationResult result = SampleResult();
  result.root = "front_lidar";
  result.rejected = {{"front_lidar", SensorResult::Type::kLidar, "too little motion", "front"},
                     {"cam_front", SensorResult::Type::kCamera, "too little motion", "cam"}};
  const RigDrawing drawing = DrawingOf(result);
  EXPECT_EQ(drawing.root, "front");
  ASSERT_EQ(drawing.sensors.size(), 3u);
  EXPECT_EQ(drawing.sensors[2].type, SensorResult::Type::kCamera);
  EXPECT_TRUE(drawing.sensors[0].T_root_sensor.translation.isApprox(result.pairs[0].T_a_b.translation));
  EXPECT_EQ(drawing.sensors[0].sigma.translation, result.pairs[0].sigma.translation);
  const RigidTransform guess = result.guesses[0].T_imu_sensor.Inverse() * result.guesses[1].T_imu_sensor;
  EXPECT_TRUE(drawing.sensors[0].guess->translation.isApprox(guess.translation));
}

}  // namespace
}  // namespace mlic::report_data_test
