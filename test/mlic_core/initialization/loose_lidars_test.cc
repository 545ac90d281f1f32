#include "mlic_core/initialization/loose_lidars.h"

#include <gtest/gtest.h>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/motions.h"
#include "mlic_sim/trajectory.h"

namespace mlic::loose_lidars_test {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kDuration = 16.0, kImuRate = 200.0, kScan = 0.1;  // s, Hz, s

// Gyroscope and odometry of a LiDAR by hand, which turns on its mount by so much in the middle of the drive.
class LooseLidars : public testing::Test {
 protected:
  LooseLidars() : motion_(sim::MakeTrajectory(sim::Scenario::kHandheld, 3, kDuration, RigidTransform())) {
    Random random(5);
    const auto noise = [&](double sigma) {
      const double x = random.Normal(), y = random.Normal(), z = random.Normal();
      return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
    };
    for (int i = 0; i <= static_cast<int>(kDuration * kImuRate); ++i) {
      const double t = i / kImuRate;
      const Eigen::Quaterniond before = motion_->PoseAt(t - 1e-4).rotation,
                               after = motion_->PoseAt(t + 1e-4).rotation;
      imu_.push_back({t, Log(before.conjugate() * after) / 2e-4 + noise(3e-3), Eigen::Vector3d::Zero()});
    }
  }

  std::optional<MountTurn> Turned(double degrees, std::uint64_t seed = 1) const {
    Random random(seed);
    std::vector<TimedPose> odometry;
    const Eigen::Quaterniond mount = FromRollPitchYaw(kDegree * Eigen::Vector3d(10.0, -40.0, 120.0));
    for (double t = 0.1; t < kDuration - 0.1; t += kScan) {
      const Eigen::Quaterniond turn =
          t < 0.5 * kDuration ? mount : ExpQuaternion({0.0, degrees * kDegree, 0.0}) * mount;
      const double x = random.Normal(), y = random.Normal(), z = random.Normal();
      RigidTransform pose = motion_->PoseAt(t) * RigidTransform{turn, {0.1, 0.0, 0.2}};
      pose.rotation = pose.rotation * ExpQuaternion(0.05 * kDegree * Eigen::Vector3d(x, y, z));
      odometry.push_back({t + 0.02, pose});
    }
    return MeasureMountTurn(imu_, odometry, AlignAngularRates(imu_, odometry, std::nullopt));
  }

  std::unique_ptr<const sim::Trajectory> motion_;
  std::vector<ImuSample> imu_;
};

TEST_F(LooseLidars, AreThoseThatTurnWhileAnotherDoesNot) {
  const auto firm = Turned(0.0), loose = Turned(1.0), other = Turned(0.0, 2);
  ASSERT_TRUE(firm && loose && other);
  std::printf("firm %.3f deg, %.1f sigmas; loose %.3f deg, %.1f sigmas\n", firm->angle / kDegree,
              firm->sigmas, loose->angle / kDegree, loose->sigmas);
  EXPECT_LT(firm->angle, 0.1 * kDegree);
  EXPECT_LT(firm->sigmas, 4.0);
  EXPECT_NEAR(loose->angle, 1.0 * kDegree, 0.1 * kDegree);
  EXPECT_EQ(FindLoose({firm, loose, std::nullopt, other}), (std::vector<bool>{false, true, false, false}));
}

TEST_F(LooseLidars, AreNoneWhereAllTurn) {
  const auto loose = Turned(1.0), other = Turned(1.0, 2);
  EXPECT_EQ(FindLoose({loose, other}), (std::vector<bool>{false, false}));
  EXPECT_EQ(FindLoose({loose}), (std::vector<bool>{false}));
}

TEST_F(LooseLidars, AreNotThoseThatHardlyTurn) {
  EXPECT_EQ(FindLoose({Turned(0.0), Turned(0.2)}), (std::vector<bool>{false, false}));
}

}  // namespace
}  // namespace mlic::loose_lidars_test
