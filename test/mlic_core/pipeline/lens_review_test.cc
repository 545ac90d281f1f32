#include "mlic_core/pipeline/lens_review.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/association/point_landmarks.h"
#include "mlic_core/sensors/double_sphere_twin.h"
#include "mlic_sim/motions.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic::lens_review_test {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kDuration = 20.0;

// A fisheye of double_sphere on a trajectory that is known, its tracks with a noise of a third of a pixel.
class LensReview : public testing::Test {
 protected:
  LensReview() : context_{rig_, dataset_, observer_, {token_, [](double) {}, [](const auto&) {}}} {
    const auto motion = sim::MakeTrajectory(sim::Scenario::kHandheld, 3, kDuration, RigidTransform());
    DriveState drive;
    drive.trajectory = TrueSpline(*motion, kDuration, kSyntheticKnots);
    CameraCalibration camera;
    camera.sensor.T_imu_sensor = {FromRollPitchYaw(kDegree * Eigen::Vector3d(-91.0, 1.0, -89.0)),
                                  {0.06, 0.11, -0.01}};
    camera.intrinsics = {CameraModel::kDoubleSphere, 720, 720, {193.8, 193.4, 357.9, 364.1, -0.1812, 0.5921}};
    adjustment_.state.cameras.push_back(camera);
    adjustment_.state.drives.push_back(drive);
    adjustment_.cameras.found = {true};
    SyntheticTracksOptions options;
    options.duration = kDuration;
    options.points = 3000;
    options.noise = 0.3;
    tracks_ = MakeTracks(drive.trajectory, adjustment_.state.cameras, options);
    rig_.cameras.resize(1);
    rig_.cameras[0].name = "fisheye";
    dataset_.drives.resize(1);
    JointProblem& problem = adjustment_.problem;
    problem.dataset = &dataset_;
    problem.fix_trajectory = true;
    problem.cameras.resize(1);
    problem.drives.resize(1);
  }

  void Triangulate() {
    LandmarkOptions options;
    options.noise.resize(1);
    adjustment_.problem.drives[0].landmarks = TriangulateLandmarks(tracks_, adjustment_.state, 0, options);
    ASSERT_GT(adjustment_.problem.drives[0].landmarks.points.size(), 300u);
  }

  double Xi() const { return adjustment_.state.cameras[0].intrinsics.parameters[4]; }

  CancellationToken token_;
  Rig rig_;
  Dataset dataset_;
  CalibrationObserver observer_;
  AdjustmentContext context_;
  Adjustment adjustment_;
  TrackSet tracks_;
};

TEST_F(LensReview, LeavesTheLensThatOnlyProjectsAlike) {
  CameraIntrinsics& intrinsics = adjustment_.state.cameras[0].intrinsics;
  const double truth = Xi();
  intrinsics = DoubleSphereTwin(intrinsics).value();
  Triangulate();
  // A solve alone does not: it stays where it began.
  SolveAdjustment(token_, &adjustment_, {});
  EXPECT_GT(Xi(), 0.2);
  EXPECT_TRUE(ReviewLenses(context_, false, &adjustment_));
  EXPECT_NEAR(Xi(), truth, 0.01);
}

TEST_F(LensReview, StaysAtTheLensThatCostsLeast) {
  const double truth = Xi();
  Triangulate();
  EXPECT_FALSE(ReviewLenses(context_, false, &adjustment_));
  EXPECT_NEAR(Xi(), truth, 0.01);
}

// Scale and shear of the IMU are judged after the lenses, by what the last solve says of them.
TEST_F(LensReview, KeepsWhatTheRoundProbes) {
  const CameraIntrinsics truth = adjustment_.state.cameras[0].intrinsics;
  for (const CameraIntrinsics& start : {truth, DoubleSphereTwin(truth).value()}) {
    adjustment_.state.cameras[0].intrinsics = start;
    Triangulate();
    ReviewLenses(context_, true, &adjustment_);
    EXPECT_GT(adjustment_.last_solve.imu_matrices.information.rows(), 0);
  }
}

TEST_F(LensReview, DoesNotTouchAFixedLens) {
  Triangulate();
  adjustment_.problem.cameras[0].fixed.intrinsics.assign(6, true);
  const std::vector<double> before = adjustment_.state.cameras[0].intrinsics.parameters;
  EXPECT_FALSE(ReviewLenses(context_, false, &adjustment_));
  EXPECT_EQ(adjustment_.state.cameras[0].intrinsics.parameters, before);
}

}  // namespace
}  // namespace mlic::lens_review_test
