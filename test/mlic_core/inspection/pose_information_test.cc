#include "mlic_core/inspection/pose_information.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/inspection/rotation_findings.h"

namespace mlic::pose_information_test {
namespace {

constexpr double kPeriod = 0.1;                     // s
constexpr double kNoise = 0.02;                     // m, along the walls' normals
const Eigen::Vector3d kHalfRoom(10.0, 10.0, 1.25);  // m

// A LiDAR that stands in the middle of a low hall, by `points` a scan in random directions. walls: without
// them the points lie anywhere in the hall.
LidarRecording InHall(int points, bool walls, std::vector<TimedPose>* poses) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> part(0.05, 1.0);
  LidarRecording recording;
  for (int s = 0; s < 40; ++s) {
    LidarScan scan;
    scan.time = s * kPeriod;
    for (int i = 0; i < points; ++i) {
      const Eigen::Vector3d direction(normal(random), normal(random), normal(random));
      int axis = 0;
      const double reach = kHalfRoom.cwiseQuotient(direction.cwiseAbs()).minCoeff(&axis);
      Eigen::Vector3d p = reach * direction;
      if (walls) p[axis] += kNoise * normal(random);
      if (!walls) p *= part(random);
      scan.points.push_back({p.cast<float>(), static_cast<float>(kPeriod * i / points), 0.0f, 0});
    }
    recording.scans.push_back(scan);
    poses->push_back({scan.time + 0.5 * kPeriod, RigidTransform()});
  }
  return recording;
}

std::optional<PoseInformation> MeasureInHall(int points, bool walls) {
  std::vector<TimedPose> poses;
  const LidarRecording recording = InHall(points, walls, &poses);
  return MeasurePoseInformation(recording, poses);
}

// Three quarters of the directions meet the nearer floor and ceiling, which tell z, and the walls share the
// rest: a point tells its wall's direction by 1 / noise^2.
TEST(PoseInformation, IsThatOfThePointsOnWalls) {
  const auto information = MeasureInHall(800, true);
  ASSERT_TRUE(information.has_value());
  const double most = 800 / kPeriod / (kNoise * kNoise);
  const Eigen::Vector3d told = information->diagonal().tail<3>() / most;
  EXPECT_LT(told.sum(), 1.2);
  EXPECT_GT(told.sum(), 0.5);
  EXPECT_GT(told.z(), 4.0 * told.x());
  EXPECT_NEAR(told.x() / told.y(), 1.0, 0.3);
}

TEST(PoseInformation, GrowsWithThePointsThatACalibrationTakes) {
  const auto few = MeasureInHall(400, true), more = MeasureInHall(1600, true),
             most = MeasureInHall(4000, true);
  ASSERT_TRUE(few && more && most);
  EXPECT_NEAR(more->trace() / few->trace(), 4.0, 1.0);
  EXPECT_NEAR(most->trace() / more->trace(), 2000.0 / 1600.0, 0.3);
}

TEST(PoseInformation, TakesPlanes) {
  EXPECT_FALSE(MeasureInHall(800, false).has_value());
  EXPECT_FALSE(MeasurePoseInformation({}, {}).has_value());
}

TEST(PoseNoise, IsAlongTheAxesOfTheImu) {
  LidarRotation lidar;
  lidar.pose_information = PoseInformation::Identity() * 1e8;
  (*lidar.pose_information)(3, 3) = 1e6;  // along its own x
  EXPECT_FALSE(PoseNoiseOf({lidar}).measured);
  lidar.guess.emplace();
  lidar.guess->T_imu_sensor.rotation = ExpQuaternion(Eigen::Vector3d(0.0, 0.0, M_PI / 2.0));
  const PoseNoise one = PoseNoiseOf({lidar}), two = PoseNoiseOf({lidar, lidar});
  EXPECT_TRUE(one.measured);
  EXPECT_NEAR(one.position(1, 1), 1e-6, 1e-8);
  EXPECT_NEAR(one.position(0, 0), 1e-8, 1e-10);
  EXPECT_NEAR(two.position(1, 1), 0.5e-6, 1e-8);
}

}  // namespace
}  // namespace mlic::pose_information_test
