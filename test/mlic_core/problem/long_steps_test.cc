// Steps that carry a camera and its landmarks far at once.
#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/association/point_landmarks.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_sim/motions.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic::long_steps_test {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kDuration = 12.0, kImuRate = 200.0;

// Camera and IMU by hand, all without noise, at the truth.
class CameraWithImu : public testing::Test {
 protected:
  CameraWithImu() {
    const auto motion = sim::MakeTrajectory(sim::Scenario::kHandheld, 3, kDuration, RigidTransform());
    DriveState drive;
    drive.trajectory = TrueSpline(*motion, kDuration, kSyntheticKnots);
    CameraCalibration camera;
    camera.sensor = {{FromRollPitchYaw(kDegree * Eigen::Vector3d(-91.0, 1.0, -89.0)), {0.06, 0.11, -0.01}},
                     -0.02};
    camera.intrinsics = {CameraModel::kPlumbBob,
                         752,
                         480,
                         {392.0, 391.0, 371.0, 244.0, -0.09, 0.018, 0.0004, -0.0006, -0.001}};
    state_.cameras.push_back(camera);
    SyntheticTracksOptions options;
    options.duration = kDuration;
    options.points = 2000;
    options.visible_seconds = 0.8;
    tracks_ = MakeTracks(drive.trajectory, state_.cameras, options);
    dataset_.drives.emplace_back();
    for (int i = 0; i <= static_cast<int>(kDuration * kImuRate); ++i) {
      const double t = i / kImuRate;
      const SplineBasis basis(drive.trajectory.position.knots(), t);
      dataset_.drives[0].imu.push_back({t, drive.trajectory.rotation.AngularVelocity(t),
                                        drive.trajectory.rotation.Rotation(t).conjugate() *
                                            (drive.trajectory.position.Acceleration(basis) - kGravity)});
    }
    state_.drives.push_back(drive);
  }

  Dataset dataset_;
  CalibrationState state_;
  TrackSet tracks_;
};

// Of the camera, at the end.
struct Errors {
  double translation, rotation;  // m, rad
};

class FarStart : public CameraWithImu {
 protected:
  // The trajectory and the map that many times too large, the camera turned by so much (rad).
  Errors SolveFrom(double scale, double turn) {
    const RigidTransform truth = state_.cameras[0].sensor.T_imu_sensor;
    state_.cameras[0].sensor.T_imu_sensor.rotation =
        truth.rotation * Eigen::AngleAxisd(turn, Eigen::Vector3d(0.3, -0.5, 0.8).normalized());
    SplitSpline& trajectory = state_.drives[0].trajectory;
    std::vector<Eigen::Vector3d> points = trajectory.position.control_points();
    for (Eigen::Vector3d& point : points) point *= scale;
    trajectory.position = PositionSpline(trajectory.position.knots(), points);
    JointProblem problem;
    problem.dataset = &dataset_;
    problem.cameras.resize(1);
    DriveTerms& terms = problem.drives.emplace_back();
    terms.imu_sigma.usual.gyroscope.setConstant(3e-3);
    terms.imu_sigma.usual.accelerometer.setConstant(3e-2);
    LandmarkOptions options;
    options.noise.resize(1);
    options.largest_error = 1e3;
    terms.landmarks = TriangulateLandmarks(tracks_, state_, 0, options);
    EXPECT_GT(terms.landmarks.points.size(), 300u);
    summary_ = SolveJointProblem(problem, 10, CancellationToken(), &state_);
    const RigidTransform& found = state_.cameras[0].sensor.T_imu_sensor;
    return {(found.translation - truth.translation).norm(), found.rotation.angularDistance(truth.rotation)};
  }

  SolveSummary summary_;
};

// The linear step of a point leaves it tens of pixels off.
TEST_F(FarStart, OfAQuarterOfTheScaleIsLeftInAFewSteps) {
  const Errors errors = SolveFrom(0.75, 0.0);
  EXPECT_EQ(summary_.refused_step.size(), 0);
  EXPECT_LT(errors.translation, 1e-4);
  EXPECT_LT(errors.rotation, 1e-5);
}

// Whole steps raise the cost, damped ones hardly move the scale (4 and 15 cm off in as many iterations).
TEST_F(FarStart, SharesOfAStepLeadOnWhereTheWholeGoesTooFar) {
  const Errors errors = SolveFrom(0.3, 5.0 * kDegree);
  EXPECT_LT(errors.translation, 1e-4);
  EXPECT_LT(errors.rotation, 1e-5);
}

}  // namespace
}  // namespace mlic::long_steps_test
