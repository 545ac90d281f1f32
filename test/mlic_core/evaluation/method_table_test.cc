#include "mlic_core/evaluation/methods/method_table.h"

#include <gtest/gtest.h>

#include "support/sample_result.h"

namespace mlic::method_table_test {
namespace {

// The joint calibration, right but for 2 mm, and a rival that is 30 mm off along z and lacks a LiDAR.
std::vector<MethodErrors> TwoMethods() {
  const CalibrationResult truth = SampleResult();
  CalibrationResult joint = truth, rival = truth;
  joint.sensors[0].calibration.T_imu_sensor.translation.x() += 0.002;
  rival.sensors[0].calibration.T_imu_sensor.translation += Eigen::Vector3d(0.004, 0.003, 0.03);
  rival.sensors.erase(rival.sensors.begin() + 1);
  rival.pairs.clear();
  return {{"joint", CompareWithTruth(joint, truth)}, {"hand_eye", CompareWithTruth(rival, truth)}};
}

std::string LineOf(const std::string& text, const std::string& begin) {
  const std::size_t at = text.find("\n" + begin);
  if (at == std::string::npos) return "no line begins with " + begin;
  return text.substr(at + 1, text.find('\n', at + 1) - at - 1);
}

// SampleResult's z is not observable, so what the rival errs along it is the guess's.
TEST(MethodTable, HasTheDistanceAlongWhatTheJointCalibrationShows) {
  const std::string csv = CsvOf(TwoMethods());
  EXPECT_EQ(LineOf(csv, "joint,sensor,front_lidar"), "joint,sensor,front_lidar,0,0.002,0.002,0");
  const std::string rival = LineOf(csv, "hand_eye,sensor,front_lidar");
  EXPECT_NE(rival.find(",0.005,0"), std::string::npos) << rival;
  const std::string table = TableOf(TwoMethods());
  EXPECT_NE(LineOf(table, "front_lidar *").find("     5.00"), std::string::npos) << table;
  EXPECT_NE(table.find("*: along the axes that the drive shows"), std::string::npos);
}

TEST(MethodTable, SaysWhatAMethodDoesNotGive) {
  const std::string csv = CsvOf(TwoMethods()), table = TableOf(TwoMethods());
  EXPECT_EQ(LineOf(csv, "hand_eye,sensor,left_lidar"), "hand_eye,sensor,left_lidar,nan,nan,nan,nan");
  EXPECT_EQ(LineOf(csv, "hand_eye,pair,front_lidar/left_lidar"),
            "hand_eye,pair,front_lidar/left_lidar,nan,nan,nan,nan");
  const std::string line = LineOf(table, "left_lidar");
  EXPECT_EQ(line.substr(line.size() - 3), "  -") << line;
}

}  // namespace
}  // namespace mlic::method_table_test
