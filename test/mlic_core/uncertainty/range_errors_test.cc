#include "mlic_core/uncertainty/range_errors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/sensors/camera_model.h"
#include "support/camera_with_imu.h"

namespace mlic::range_errors_test {
namespace {

constexpr double kTooLong = 0.02;  // m, all ranges

// Points that a LiDAR at rest against camera and IMU measures, each seen in an image of about the same time.
LandmarkSet PointsOnTheMap(const CameraWithImu& c) {
  constexpr float kPixel = 0.3f;  // px
  Random random(5);
  LandmarkSet set;
  set.begin.push_back(0);
  const SplitSpline& trajectory = c.state.drives[0].trajectory;
  const CameraCalibration& camera = c.state.cameras[0];
  const SensorCalibration& lidar = c.state.lidars[0];
  for (const Keyframe& keyframe : c.tracks[0].keyframes) {
    const double seen = camera.sensor.OnImuClock(keyframe.time, trajectory.Middle()), measured = seen + 0.05;
    if (!trajectory.Contains(seen) || !trajectory.Contains(measured)) continue;
    const RigidTransform T_map_camera = trajectory.Pose(seen) * camera.sensor.T_imu_sensor;
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d in_camera(random.Uniform(-2.0, 2.0), random.Uniform(-1.0, 1.0),
                                      random.Uniform(3.0, 8.0));
      Eigen::Vector2d pixel;
      if (!Project(camera.intrinsics, in_camera, &pixel)) continue;
      const Eigen::Vector3d point = T_map_camera * in_camera;
      LidarPointObservation lidar_point;
      lidar_point.lidar = 0;
      lidar_point.time = measured;  // its clock is the IMU's
      lidar_point.position = (trajectory.Pose(measured) * lidar.T_imu_sensor).Inverse() * point;
      lidar_point.position *= 1.0 + kTooLong / lidar_point.position.norm();
      lidar_point.sigma_along = 5e-3f;
      lidar_point.sigma_across = 3e-3f;
      set.points.push_back({point, T_map_camera.translation});
      set.lidar_points.push_back(lidar_point);
      set.observations.push_back({0, kPixel, keyframe.time, pixel});
      set.begin.push_back(set.observations.size());
    }
  }
  return set;
}

// A camera that stands off the LiDAR sees where the points are.
TEST(RangeEquations, OfPointsThatACameraSeesFromElsewhere) {
  CameraWithImu c = MakeCameraWithImu(3, 10, NoCommonError);
  SensorCalibration lidar;
  lidar.T_imu_sensor.translation = {0.1, -0.8, 0.5};
  c.state.lidars = {lidar};
  JointProblem problem;
  problem.dataset = &c.dataset;
  problem.lidars.resize(1);
  problem.lidars[0].fixed = true;
  problem.cameras.resize(1);
  FixedCameraParameters& held = problem.cameras[0].fixed;
  held.rotation = held.translation = held.time_offset = true;
  held.intrinsics.assign(c.state.cameras[0].intrinsics.parameters.size(), true);
  DriveTerms& drive = problem.drives.emplace_back();
  drive.imu_sigma = {c.imu_sigma};
  drive.planes.begin.push_back(0);
  drive.landmarks = PointsOnTheMap(c);
  const auto found =
      RangeEquations(problem, c.state).Measure(RangeModel::kWhole, {{true, false, false, false}});
  ASSERT_TRUE(found);
  const double sigma = std::sqrt(found->covariance(kRangeOffset, kRangeOffset));
  std::printf("offset %.4f m, sigma %.4f m\n", found->steps[0][kRangeOffset], sigma);
  EXPECT_LT(sigma, 5e-3);
  EXPECT_NEAR(found->steps[0][kRangeOffset], -kTooLong, 0.1 * kTooLong);
}

}  // namespace
}  // namespace mlic::range_errors_test
