#include "mlic_core/pipeline/stamp_review.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "mlic_core/pipeline/joint_adjustment.h"
#include "support/camera_with_imu.h"

namespace mlic::stamp_review_test {
namespace {

constexpr double kGyroscopeNoise = 0.1;  // of CameraWithImu's: a tactical one

// A camera and an IMU from the truth on, whose gyroscope errs in scale and shear and whose images come late
// by so much (s, by their time).
Adjustment Adjusted(const Eigen::Matrix3d& gyroscope, const std::function<double(double)>& late) {
  CameraWithImu c = MakeCameraWithImu(3, 12000, NoCommonError);
  const So3Spline& rotation = c.state.drives[0].trajectory.rotation;
  for (ImuSample& sample : c.dataset.drives[0].imu) {
    const Eigen::Vector3d truth = rotation.AngularVelocity(sample.time);
    sample.angular_velocity = gyroscope * truth + kGyroscopeNoise * (sample.angular_velocity - truth);
  }
  c.imu_sigma.gyroscope *= kGyroscopeNoise;
  for (Keyframe& keyframe : c.tracks[0].keyframes) keyframe.time -= late(keyframe.time);
  Rig rig;
  rig.cameras.resize(1);
  rig.cameras[0].name = "camera";
  rig.cameras[0].model = c.state.cameras[0].intrinsics.model;
  Initialization start;
  start.state.drives = c.state.drives;
  start.imu_sigma = {c.imu_sigma};
  CameraInitialization cameras;
  cameras.cameras = c.state.cameras;
  cameras.held.resize(1);
  cameras.held[0].intrinsics.assign(c.state.cameras[0].intrinsics.parameters.size(), false);
  cameras.noise.resize(1);
  cameras.found = {true};
  CalibrationObserver observer;
  const CancellationToken token;
  const AdjustmentContext context{rig, c.dataset, observer, {token, [](double) {}, [](const auto&) {}}};
  Adjustment adjustment = StartAdjustment(rig, c.dataset, start);
  AddCameras(rig, cameras, c.tracks, &adjustment);
  JointOptions options;
  options.landmarks = Landmarks::kTracks;
  adjustment = AdjustJointly(adjustment, context, options);
  adjustment.problem.dataset = nullptr;  // which ends here
  return adjustment;
}

double WanderOf(const Adjustment& adjustment) { return std::sqrt(StampWander(adjustment, 0)); }

double None(double) { return 0.0; }

TEST(StampReview, DoesNotKeepForTheStampsWhatIsTheGyroscopes) {
  Eigen::Matrix3d gyroscope = Eigen::Matrix3d::Identity();
  gyroscope << 1.003, 0.0, 0.0, 0.002, 0.998, 0.0, -0.002, 0.003, 1.002;
  const Adjustment adjustment = Adjusted(gyroscope, None);
  ASSERT_TRUE(adjustment.problem.estimate_imu_matrices);
  EXPECT_LT(WanderOf(adjustment), 2e-5);
  EXPECT_LT((adjustment.state.gyroscope_matrix - gyroscope).cwiseAbs().maxCoeff(), 3e-4);
}

TEST(StampReview, FollowsStampsThatWander) {
  const auto late = [](double time) { return 1e-3 * std::sin(2.0 * M_PI * time / 9.0); };
  const Adjustment adjustment = Adjusted(Eigen::Matrix3d::Identity(), late);
  EXPECT_GT(WanderOf(adjustment), 4e-4);
  EXPECT_LT(WanderOf(adjustment), 9e-4);
}

}  // namespace
}  // namespace mlic::stamp_review_test
