#include "mlic_core/uncertainty/adjustment.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "mlic_core/problem/layout.h"

namespace mlic::adjustment_test {
namespace {

constexpr double kDuration = 40.0;  // s

// A camera whose parameters are all known to a thousandth (m, rad, s), after a solve that stands still.
class OneCamera : public testing::Test {
 protected:
  OneCamera() {
    const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, 1.0);
    DriveState drive;
    drive.trajectory.rotation =
        So3Spline(knots, std::vector<Eigen::Quaterniond>(knots.count, Eigen::Quaterniond::Identity()));
    drive.trajectory.position =
        PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()));
    adjustment_.state.drives = {drive};
    CameraCalibration camera;
    camera.intrinsics = {CameraModel::kPlumbBob, 640, 480, {400.0, 400.0, 320.0, 240.0, 0, 0, 0, 0, 0}};
    adjustment_.state.cameras = {camera};
    adjustment_.problem.cameras.resize(1);
    adjustment_.problem.dataset = &dataset_;
    dataset_.drives.resize(1);
  }
  // One clock that drifts by so much, s/s.
  void Drift(double drift) {
    adjustment_.state.cameras[0].sensor.clock_drift = drift;
    const Layout layout(adjustment_.state, false);
    adjustment_.last_solve.information =
        1e6 * Eigen::MatrixXd::Identity(layout.calibration, layout.calibration);
  }
  double OffsetSigma() const { return Analyze(adjustment_, dataset_).sigmas[0].time_offset; }

  Dataset dataset_;
  Adjustment adjustment_;
};

TEST_F(OneCamera, AnOffsetThatMovesFasterThanClocksDoIsUnsureByThat) {
  Drift(5e-5);
  const double of_clock = OffsetSigma();
  EXPECT_NEAR(of_clock, 1e-3, 1e-5);
  Drift(-2e-4);
  EXPECT_NEAR(OffsetSigma(), std::hypot(of_clock, 2e-4 * kDuration / std::sqrt(12.0)), 1e-5);
}

// Light that changes the exposure by a millisecond is no clock's drift.
TEST_F(OneCamera, ADriftIsUnsureByWhatAnExposureMoves) {
  Drift(5e-5);
  adjustment_.last_solve.information *= 1e8;
  const double length =
      adjustment_.state.drives[0].trajectory.End() - adjustment_.state.drives[0].trajectory.Start();
  EXPECT_NEAR(Analyze(adjustment_, dataset_).sensors[0].drift_sigma, 1e-3 / length, 1e-7);
}

TEST_F(OneCamera, ErrorsThatPointsShareAreInTheSigmaAndNotInTheBound) {
  Drift(5e-5);
  adjustment_.scale.correlation = 4.0;
  EXPECT_NEAR(OffsetSigma(), 2e-3, 2e-5);
  EXPECT_NEAR(AnalyzeBound(adjustment_).sigmas[0].time_offset, 1e-3, 1e-5);
}

// A tenth of the information on x is the motion's, and its sigma ten times larger for that. Errors that
// points share double the gradient's variance along all directions alike: so they do the estimate's.
TEST_F(OneCamera, SharedErrorsAddAsMuchWhereMostOfTheInformationIsNoise) {
  Drift(0.0);
  const Eigen::MatrixXd& information = adjustment_.last_solve.information;
  adjustment_.noise_information = Eigen::MatrixXd::Zero(information.rows(), information.cols());
  adjustment_.noise_information(3, 3) = 0.9 * information(3, 3);
  EXPECT_NEAR(Analyze(adjustment_, dataset_).sigmas[0].translation.x(), 1e-2, 1e-4);
  adjustment_.scale.inflation.points = information;
  const Eigen::Vector3d sigma = Analyze(adjustment_, dataset_).sigmas[0].translation;
  EXPECT_NEAR(sigma.y(), std::sqrt(2.0) * 1e-3, 1e-5);
  EXPECT_NEAR(sigma.x(), std::sqrt(2.0) * 1e-2, 1e-4);
}

TEST_F(OneCamera, ResidualsCountOnceForEachOfTheirDimensions) {
  adjustment_.last_solve.observations = 100;
  adjustment_.last_solve.landmark_observations = 10;
  dataset_.drives[0].imu.resize(20);
  adjustment_.last_solve.last_cost = 60.0;
  EXPECT_NEAR(MeanSquaredResidual(adjustment_, dataset_), 60.0 / (100.0 + 20.0 + 120.0), 1e-12);
}

TEST_F(OneCamera, ThatNoSolveHasSeenIsNotShown) {
  const ObservabilityAnalysis analysis = Analyze(adjustment_, dataset_);
  ASSERT_EQ(analysis.sensors.size(), 1u);
  EXPECT_FALSE(analysis.sensors[0].time_offset);
  EXPECT_EQ(analysis.sensors[0].rotation, (std::array<bool, 3>{false, false, false}));
}

TEST_F(OneCamera, AStepThatWasRefusedIsStillToGo) {
  Drift(0.0);
  const CalibrationState before = adjustment_.state;
  EXPECT_EQ(ChangeInSigmas(adjustment_, dataset_, before), 0.0);
  const Layout layout(adjustment_.state, false);
  adjustment_.last_solve.refused_step = Eigen::VectorXd::Zero(layout.calibration);
  adjustment_.last_solve.refused_step[3] = -4e-3;
  EXPECT_NEAR(ChangeInSigmas(adjustment_, dataset_, before), 4.0, 0.04);
}

}  // namespace
}  // namespace mlic::adjustment_test
