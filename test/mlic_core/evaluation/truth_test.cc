#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/evaluation/truth_comparison.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/sensors/imu_matrices.h"
#include "support/sample_result.h"

namespace mlic::truth_test {
namespace {

const PoseError& Named(const std::vector<PoseError>& errors, const std::string& name) {
  for (const PoseError& error : errors) {
    if (error.name == name) return error;
  }
  throw std::runtime_error("no error named " + name);
}

TEST(TruthComparison, ItselfHasNoError) {
  const CalibrationResult result = SampleResult();
  const TruthComparison comparison = CompareWithTruth(result, result);
  EXPECT_EQ(comparison.sensors.size(), 4u);
  EXPECT_EQ(comparison.pairs.size(), 6u);
  EXPECT_TRUE(comparison.not_estimated.empty());
  for (const PoseError& error : comparison.sensors) {
    EXPECT_LT(error.RotationDegrees(), 1e-6);
    EXPECT_EQ(error.translation.norm(), 0.0);
    EXPECT_EQ(*error.time_offset, 0.0);
  }
  for (const PoseError& error : comparison.pairs) EXPECT_LT(error.translation.norm(), 1e-12);
}

TEST(TruthComparison, FindsTheErrorsThatWerePutIn) {
  const CalibrationResult truth = SampleResult();
  CalibrationResult result = truth;
  SensorCalibration& left = result.sensors[1].calibration;
  const Eigen::Vector3d rotation(1e-4, -2e-4, 3e-4), translation(0.001, -0.002, 0.003);
  left.T_imu_sensor.rotation = ExpQuaternion(rotation) * left.T_imu_sensor.rotation;
  left.T_imu_sensor.translation += translation;
  left.time_offset += 2e-4;
  result.pairs[0].T_a_b =
      result.sensors[0].calibration.T_imu_sensor.Inverse() * result.sensors[1].calibration.T_imu_sensor;
  const TruthComparison comparison = CompareWithTruth(result, truth);
  const PoseError& error = Named(comparison.sensors, "left_lidar");
  EXPECT_LT((error.rotation - rotation).norm(), 1e-12);
  EXPECT_LT((error.translation - translation).norm(), 1e-12);
  EXPECT_NEAR(error.RotationDegrees(), rotation.norm() * 180.0 / M_PI, 1e-9);
  EXPECT_NEAR(error.normalised_translation.y(), -0.002 / 0.0014, 1e-9);
  EXPECT_NEAR(error.normalised_rotation.z(), 3e-4 / 0.9e-4, 1e-9);
  EXPECT_NEAR(error.normalised_time_offset, 2e-4 / 8.5e-5, 1e-9);
  const PoseError& pair = Named(comparison.pairs, "front_lidar/left_lidar");
  EXPECT_NEAR(pair.rotation.norm(), rotation.norm(), 1e-10);
  EXPECT_NEAR(pair.translation.norm(), translation.norm(), 1e-10);
  EXPECT_NEAR(*pair.time_offset, 2e-4, 1e-12);
  EXPECT_LT(Named(comparison.pairs, "front_lidar/right_lidar").RotationDegrees(), 1e-6);
}

// About the vertical the result stands in the accelerometer's axes, about the others in the gyroscope's.
TEST(TruthComparison, TakesTheAxesThatTheResultHas) {
  const CalibrationResult truth = SampleResult();
  CalibrationResult result = truth;
  const Eigen::Quaterniond heading = ExpQuaternion({0.0, 0.0, 0.05});
  const RotationAndTriangle found = SplitAccelerometerMatrix(truth.imu.accelerometer_matrix);
  CalibrationResult turned = truth;
  turned.imu.accelerometer_matrix = found.rotation * heading.toRotationMatrix() * found.triangle;
  for (SensorResult& sensor : result.sensors) {
    RigidTransform& T = sensor.calibration.T_imu_sensor;
    T = {heading * T.rotation, heading * T.translation};
  }
  for (const PoseError& error : CompareWithTruth(result, turned).sensors) {
    EXPECT_LT(error.RotationDegrees(), 1e-6);
    EXPECT_LT(error.translation.norm(), 1e-12);
  }
  result.alignment->of_accelerometer.clear();
  for (const PoseError& error : CompareWithTruth(result, turned).sensors) {
    EXPECT_NEAR(error.RotationDegrees(), 0.05 * 180.0 / M_PI, 1e-6);
  }
}

// A truth whose gyroscope is turned is compared in the gyroscope's axes.
TEST(TruthComparison, TakesTheGyroscopesAxesWhereItIsTurned) {
  CalibrationResult result = SampleResult();
  result.alignment->of_accelerometer.clear();
  CalibrationResult truth = result;
  const Eigen::Quaterniond turn = ExpQuaternion({0.004, -0.002, 0.003});
  truth.imu.gyroscope_matrix *= turn.toRotationMatrix();
  truth.imu.accelerometer_matrix *= turn.toRotationMatrix();
  for (SensorResult& sensor : truth.sensors) {
    RigidTransform& T = sensor.calibration.T_imu_sensor;
    T = {turn.conjugate() * T.rotation, turn.conjugate() * T.translation};
  }
  for (const PoseError& error : CompareWithTruth(result, truth).sensors) {
    EXPECT_LT(error.RotationDegrees(), 1e-6);
    EXPECT_LT(error.translation.norm(), 1e-12);
  }
}

TEST(TruthComparison, SwappingEstimateAndTruthTurnsTheSigns) {
  const CalibrationResult truth = SampleResult();
  CalibrationResult result = truth;
  Random random(5);
  for (SensorResult& sensor : result.sensors) {
    const Eigen::Vector3d v(random.Normal(), random.Normal(), random.Normal());
    sensor.calibration.T_imu_sensor.rotation =
        ExpQuaternion(0.01 * v) * sensor.calibration.T_imu_sensor.rotation;
    sensor.calibration.T_imu_sensor.translation += v;
  }
  const TruthComparison forward = CompareWithTruth(result, truth), backward = CompareWithTruth(truth, result);
  for (std::size_t i = 0; i < forward.sensors.size(); ++i) {
    EXPECT_LT((forward.sensors[i].rotation + backward.sensors[i].rotation).norm(), 1e-12);
    EXPECT_LT((forward.sensors[i].translation + backward.sensors[i].translation).norm(), 1e-12);
  }
}

TEST(TruthComparison, PairsAreComposedWhereTheFileHasNone) {
  CalibrationResult result = SampleResult();
  const CalibrationResult truth = result;
  result.pairs.clear();
  result.sensors.pop_back();
  const TruthComparison comparison = CompareWithTruth(result, truth);
  EXPECT_EQ(comparison.pairs.size(), 3u);
  ASSERT_EQ(comparison.not_estimated.size(), 1u);
  EXPECT_EQ(comparison.not_estimated[0], "cam_front");
  EXPECT_TRUE(std::isnan(comparison.pairs[0].normalised_translation.x()));
}

TEST(TruthComparison, TableAndCsvHaveALineForEach) {
  const CalibrationResult result = SampleResult();
  const TruthComparison comparison = CompareWithTruth(result, result);
  const std::string csv = CsvOf(comparison), table = TableOf(comparison);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 11);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 12);
  const std::string header = csv.substr(0, csv.find('\n'));
  const std::string first =
      csv.substr(csv.find('\n') + 1, csv.find('\n', csv.find('\n') + 1) - csv.find('\n') - 1);
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(first.begin(), first.end(), ','));
  EXPECT_NE(table.find('*'), std::string::npos) << "z is not observable in this sample";
}

}  // namespace
}  // namespace mlic::truth_test
