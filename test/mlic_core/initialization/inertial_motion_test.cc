#include "mlic_core/initialization/inertial_motion.h"

#include <gtest/gtest.h>

#include "mlic_core/geometry/so3.h"
#include "support/test_motion.h"

namespace mlic::inertial_motion_test {
namespace {

TEST(InertialMotion, PredictsALidarOnALeverArm) {
  test::Rig rig;
  rig.time_offset = 0.03;
  const test::Motion motion = test::HandHeld();
  const auto recording = test::Record(motion, rig, {}, 400.0, 10.0, 1);
  AngularRateAlignment alignment;
  alignment.time_offset = rig.time_offset;
  alignment.gyroscope_bias = rig.gyroscope_bias;
  alignment.R_imu_lidar = rig.T_imu_lidar.rotation;
  const auto pose = [&](double time) { return motion.T_map_imu(time + rig.time_offset) * rig.T_imu_lidar; };
  const auto velocity = [&](double time) -> Eigen::Vector3d {
    return (pose(time + 1e-4).translation - pose(time - 1e-4).translation) / 2e-4;
  };
  constexpr double kFirst = 1.0;
  GravityLeverArm arm;
  arm.R_imu_lidar = rig.T_imu_lidar.rotation;
  arm.p_imu_lidar = rig.T_imu_lidar.translation;
  arm.accelerometer_bias = rig.accelerometer_bias;
  const Eigen::Vector3d gravity(0.0, 0.0, -9.81);
  arm.gravity = pose(kFirst).rotation.conjugate() * gravity;
  const InertialMotion inertial = MotionByImu(recording.imu, alignment, arm, ClockDrift());
  EXPECT_EQ(inertial.gravity, arm.gravity);
  for (const double from : {2.0, 3.37, 7.21}) {
    const double T = 0.1, to = from + T;
    const Eigen::Quaterniond turned = pose(from).rotation.conjugate() * pose(to).rotation;
    EXPECT_LT(AngleBetween(inertial.rotation(from, to).value(), turned), 1e-6);
    const LinearGain gain = inertial.gain(from, to);
    const Eigen::Quaterniond R = pose(from).rotation;
    const Eigen::Vector3d gained = T * gravity + R * gain.velocity;
    // The rates at both ends are means over 20 ms.
    EXPECT_LT((velocity(from) + gained - velocity(to)).norm(), 2e-3);
    const Eigen::Vector3d moved = T * velocity(from) + 0.5 * T * T * gravity + R * gain.position;
    EXPECT_LT((pose(from).translation + moved - pose(to).translation).norm(), 2e-4);
  }
  EXPECT_FALSE(inertial.rotation(9.9, 10.5).has_value());
}

}  // namespace
}  // namespace mlic::inertial_motion_test
