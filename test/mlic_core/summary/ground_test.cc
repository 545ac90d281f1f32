#include "mlic_core/summary/ground.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::ground_test {
namespace {

constexpr double kDegree = M_PI / 180.0;
const Eigen::Vector3d kRoll(1.5 * kDegree, -4.0 * kDegree, 0.0);  // of the IMU over the ground

// A slope that a vehicle drives up, with points good to 2 cm.
class Slope {
 public:
  explicit Slope(double height) : height_(height) {}

  RigidTransform PoseAt(double along) const {
    const RigidTransform T_map_ground{tilt_, Eigen::Vector3d::Zero()};
    const Eigen::Quaterniond yaw(Eigen::AngleAxisd(0.1 * along, Eigen::Vector3d::UnitZ()));
    return T_map_ground * RigidTransform{yaw * FromRollPitchYaw(kRoll), {along, 0.3 * along, height_}};
  }

  std::vector<StampedPose> Drive(double length) const {
    std::vector<StampedPose> poses;
    for (int k = 0; k * 0.05 <= length; ++k) poses.push_back({k * 10000000LL, PoseAt(0.05 * k)});
    return poses;
  }

  // In the ground's frame: on the ground, z 0.
  void Add(const Eigen::Vector3d& low, const Eigen::Vector3d& size, int count, std::vector<MapPoint>* map) {
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector3d at =
          low + size.cwiseProduct(Eigen::Vector3d(random_.Uniform(), random_.Uniform(), random_.Uniform()));
      MapPoint point;
      point.position = (tilt_ * (at + 0.02 * random_.Normal() * Eigen::Vector3d::UnitZ())).cast<float>();
      map->push_back(point);
    }
  }

  const Eigen::Quaterniond tilt_ = FromRollPitchYaw({2.0 * kDegree, -5.0 * kDegree, 0.0});

 private:
  double height_;
  Random random_{5};
};

SensorResult Lidar(double height_sigma, double rotation_sigma) {
  SensorResult lidar;
  lidar.sigma.translation = {0.001, 0.001, height_sigma};
  lidar.sigma.rotation.setConstant(rotation_sigma);
  return lidar;
}

TEST(PoseOverGround, IsThatOverASlopeAmongClutter) {
  Slope slope(1.62);
  std::vector<MapPoint> map;
  slope.Add({-5.0, -5.0, 0.0}, {30.0, 15.0, 0.0}, 60000, &map);
  slope.Add({-5.0, -3.0, 0.0}, {30.0, 0.0, 2.5}, 20000, &map);   // a wall
  slope.Add({5.0, 1.0, 0.75}, {1.5, 0.8, 0.0}, 4000, &map);      // a table
  slope.Add({-5.0, -5.0, 2.6}, {30.0, 15.0, 0.0}, 30000, &map);  // a ceiling
  const auto found = FindPoseOverGround(slope.Drive(20.0), map, {Lidar(0.1, 1e-5), Lidar(0.004, 2e-4)});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->mean.height, 1.62, 0.004);
  EXPECT_NEAR(found->mean.roll, kRoll.x(), 0.05 * kDegree);
  EXPECT_NEAR(found->mean.pitch, kRoll.y(), 0.05 * kDegree);
  EXPECT_NEAR(found->up.norm(), 1.0, 1e-12);
  EXPECT_LT(AngleBetween(Eigen::Quaterniond::FromTwoVectors(found->up, Eigen::Vector3d::UnitZ()),
                         FromRollPitchYaw(kRoll)),
            0.1 * kDegree);
  EXPECT_LT(found->scatter.height, 0.01);
  EXPECT_LT(found->scatter.roll, 0.3 * kDegree);
  // The LiDARs' own sigmas are in it, each of the one that is known best.
  EXPECT_NEAR(found->sigma.height, 0.004, 0.001);
  EXPECT_GE(found->places, 18u);
}

TEST(PoseOverGround, ScattersWithTheHeightAtWhichARigIsCarried) {
  Slope slope(1.2);
  std::vector<MapPoint> map;
  slope.Add({-5.0, -5.0, 0.0}, {30.0, 15.0, 0.0}, 60000, &map);
  std::vector<StampedPose> drive = slope.Drive(20.0);
  Random random(8);
  double sum = 0.0;
  for (StampedPose& pose : drive) {
    const double lift = 0.1 * std::sin(sum += random.Uniform(0.0, 0.4));
    pose.pose.translation += slope.tilt_ * Eigen::Vector3d(0.0, 0.0, lift);
  }
  const auto found = FindPoseOverGround(drive, map, {Lidar(0.001, 1e-5)});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->mean.height, 1.2, 0.06);
  EXPECT_GT(found->scatter.height, 0.04);
  EXPECT_LT(found->scatter.height, 0.1);
}

TEST(PoseOverGround, IsNoneWhereTheMapHasNoGroundBelow) {
  Slope slope(1.5);
  std::vector<MapPoint> map;
  slope.Add({-5.0, -2.0, 0.0}, {30.0, 0.0, 4.0}, 20000, &map);  // a wall beside the path
  slope.Add({-5.0, -5.0, 2.6}, {30.0, 15.0, 0.0}, 30000, &map);
  EXPECT_FALSE(FindPoseOverGround(slope.Drive(20.0), map, {Lidar(0.001, 1e-5)}));
  EXPECT_FALSE(FindPoseOverGround(slope.Drive(20.0), {}, {}));
  slope.Add({-5.0, -5.0, 0.0}, {30.0, 15.0, 0.0}, 60000, &map);
  EXPECT_FALSE(FindPoseOverGround(slope.Drive(1.5), map, {Lidar(0.001, 1e-5)})) << "hardly moves";
}

}  // namespace
}  // namespace mlic::ground_test
