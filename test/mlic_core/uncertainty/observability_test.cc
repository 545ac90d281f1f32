#include "mlic_core/uncertainty/observability.h"

#include <gtest/gtest.h>

#include "mlic_core/common/angles.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/uncertainty/held_translations.h"

namespace mlic::observability_test {
namespace {

using Axes = std::array<bool, 3>;

CalibrationState OneDrive() {
  CalibrationState state;
  state.drives.resize(1);
  const UniformKnots knots = UniformKnots::Covering(0.0, 1.0, 0.5);
  state.drives[0].trajectory = {
      So3Spline(knots, std::vector<Eigen::Quaterniond>(knots.count, Eigen::Quaterniond::Identity())),
      PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()))};
  return state;
}

// One LiDAR whose translation the data show to a millimetre, but along `hidden` to ten metres, and its
// rotation to 0.1 mrad, but about `hidden` to turn_sigma (rad).
ObservabilityAnalysis::Sensor Analyzed(const Eigen::Vector3d& hidden, double guess_sigma,
                                       double turn_sigma = 1e-4) {
  CalibrationState state = OneDrive();
  state.lidars.resize(1);
  JointProblem problem;
  problem.lidars.resize(1);
  if (guess_sigma > 0.0) {
    problem.lidars[0].guess.emplace();
    problem.lidars[0].guess->sigma_translation.setConstant(guess_sigma);
  }
  const int calibration = Layout(state, false).calibration;
  Eigen::MatrixXd information = 1e8 * Eigen::MatrixXd::Identity(calibration, calibration);
  const Eigen::Vector3d along = hidden.normalized();
  information.block<3, 3>(Layout::Lidar(0) + 3, Layout::Lidar(0) + 3) =
      1e6 * Eigen::Matrix3d::Identity() + (1e-2 - 1e6) * along * along.transpose();
  information.block<3, 3>(Layout::Lidar(0), Layout::Lidar(0)) +=
      (1.0 / (turn_sigma * turn_sigma) - 1e8) * along * along.transpose();
  return AnalyzeCalibration(problem, state, information).sensors[0];
}

// The vertical of a car whose IMU is mounted a degree askew.
TEST(Observability, AxesThatHardlyLieAlongTheGuessAreShown) {
  const ObservabilityAnalysis::Sensor sensor = Analyzed({0.02, 0.01, 1.0}, 0.1);
  EXPECT_EQ(sensor.translation, (Axes{true, true, false}));
  ASSERT_EQ(sensor.directions.size(), 1u);
  EXPECT_NEAR(sensor.directions[0].sigma, 0.1, 1e-4);
}

TEST(Observability, AxesThatErrByTheGuessAreNot) {
  EXPECT_EQ(Analyzed({0.5, 0.01, 1.0}, 0.1).translation, (Axes{false, true, false}));
  // As well as the limit, but what it says is not the data's.
  EXPECT_EQ(Analyzed({0.02, 0.01, 1.0}, 0.03).translation, (Axes{true, true, false}));
}

// The guess, of 5 deg here, does not hold a rotation that the data show to 0.6.
TEST(Observability, RotationsAreAsTheDataShowThem) {
  const ObservabilityAnalysis::Sensor sensor = Analyzed({0.3, 0.01, 1.0}, 0.1, 0.6 * kRadiansPerDegree);
  EXPECT_EQ(sensor.rotation, (Axes{true, true, false}));
  EXPECT_NEAR(sensor.least_rotation.sigma, 0.6 * kRadiansPerDegree, 1e-5);
}

TEST(Observability, WithoutAGuessTheHiddenDirectionSpoilsAll) {
  EXPECT_EQ(Analyzed({0.02, 0.01, 1.0}, 0.0).translation, (Axes{false, false, false}));
}

// A LiDAR and a camera whose heights the data show to ten metres, and to a millimetre against each other: one
// direction is held, also where the camera's errors are said to be twice what they seem and the LiDAR's are
// not.
TEST(Observability, SensorsThatRiseTogetherAreHeldTogether) {
  CalibrationState state = OneDrive();
  state.lidars.resize(1);
  state.cameras.resize(1);
  state.cameras[0].intrinsics = {CameraModel::kPlumbBob, 640, 480, {500, 500, 320, 240, 0, 0, 0, 0, 0}};
  JointProblem problem;
  problem.lidars.resize(1);
  problem.cameras.resize(1);
  problem.lidars[0].guess.emplace();
  problem.lidars[0].guess->sigma_translation.setConstant(0.1);
  problem.cameras[0].guess = problem.lidars[0].guess;
  const Layout layout(state, false);
  Eigen::VectorXd together = Eigen::VectorXd::Zero(layout.calibration), apart = together;
  const int lidar = Layout::Lidar(0) + 5, camera = layout.Camera(0) + 5;
  together[lidar] = together[camera] = apart[lidar] = std::sqrt(0.5);
  apart[camera] = -apart[lidar];
  Eigen::MatrixXd information = 1e8 * Eigen::MatrixXd::Identity(layout.calibration, layout.calibration);
  information += (1e6 - 1e8) * apart * apart.transpose() + (1e-2 - 1e8) * together * together.transpose();
  Inflation inflation;
  inflation.cameras.information = 0.5 * information;
  inflation.cameras.self_weighing = inflation.cameras.pattern = 0.0 * information;
  inflation.cameras.growth = Eigen::VectorXd::Ones(layout.calibration);
  inflation.cameras.growth.segment<3>(layout.Camera(0) + 3).setConstant(2.0);
  const ObservabilityAnalysis analysis = AnalyzeCalibration(problem, state, information, inflation);
  EXPECT_FALSE(analysis.sensors[0].translation[2]);
  EXPECT_FALSE(analysis.sensors[1].translation[2]);
  EXPECT_EQ(UnobservableTranslations(problem, state.Sensors(), analysis).size(), 1u);
}

}  // namespace
}  // namespace mlic::observability_test
