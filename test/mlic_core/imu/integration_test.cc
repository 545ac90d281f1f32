#include <gtest/gtest.h>

#include <algorithm>

#include "mlic_core/common/error.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/imu/gyro_integration.h"
#include "mlic_core/imu/specific_force_integration.h"
#include "support/test_motion.h"

namespace mlic::integration_test {
namespace {

using test::HandHeld;
using test::Record;

TEST(GyroIntegration, FollowsAHandHeldMotionAt100Hz) {
  const auto recording = Record(HandHeld(), {}, {}, 100.0, 20.0, 1);
  const GyroIntegration gyro(recording.imu, test::Rig().gyroscope_bias);
  double largest = 0.0;
  for (double t = 0.513; t < 19.0; t += 0.0731) {
    const auto truth = HandHeld().T_map_imu(t).rotation.conjugate() * HandHeld().T_map_imu(t + 0.1).rotation;
    largest = std::max(largest, AngleBetween(truth, gyro.RotationBetween(t, t + 0.1)));
  }
  RecordProperty("largest_error_rad", std::to_string(largest));
  EXPECT_LT(largest, 1e-5);
}

TEST(GyroIntegration, ErrorFallsWithTheFourthPowerOfThePeriod) {
  double errors[2];
  for (int i = 0; i < 2; ++i) {
    const auto recording = Record(HandHeld(), {}, {}, i == 0 ? 100.0 : 200.0, 10.0, 1);
    const GyroIntegration gyro(recording.imu, test::Rig().gyroscope_bias);
    const auto truth = HandHeld().T_map_imu(1.0).rotation.conjugate() * HandHeld().T_map_imu(8.3).rotation;
    errors[i] = AngleBetween(truth, gyro.RotationBetween(1.0, 8.3));
  }
  EXPECT_GT(errors[0] / errors[1], 10.0);
}

TEST(GyroIntegration, InvertsWhenTimesAreSwapped) {
  const auto recording = Record(HandHeld(), {}, {}, 200.0, 5.0, 1);
  const GyroIntegration gyro(recording.imu);
  EXPECT_LT(AngleBetween(gyro.RotationBetween(1.234, 3.21), gyro.RotationBetween(3.21, 1.234).conjugate()),
            1e-14);
}

TEST(GyroIntegration, BiasJacobianAgreesWithDifferences) {
  const auto recording = Record(HandHeld(), {}, {}, 200.0, 5.0, 1);
  const GyroIntegration gyro(recording.imu);
  const double t0 = 3.113, t1 = 1.217, step = 1e-5;
  const Eigen::Matrix3d jacobian = gyro.BiasJacobian(t0, t1);
  for (int axis = 0; axis < 3; ++axis) {
    const GyroIntegration changed(recording.imu, step * Eigen::Vector3d::Unit(axis));
    const Eigen::Vector3d difference =
        Log(Eigen::Quaterniond(gyro.RotationBetween(t0, t1).conjugate() * changed.RotationBetween(t0, t1)));
    EXPECT_LT((difference / step - jacobian.col(axis)).norm(), 1e-4);
  }
}

TEST(GyroIntegration, GapsAreNotCovered) {
  auto recording = Record(HandHeld(), {}, {}, 200.0, 5.0, 1);
  recording.imu.erase(recording.imu.begin() + 400, recording.imu.begin() + 420);  // 2.0 to 2.1 s
  const GyroIntegration gyro(recording.imu);
  EXPECT_TRUE(gyro.Covers(0.5, 1.9));
  EXPECT_TRUE(gyro.Covers(4.9, 2.2));
  EXPECT_FALSE(gyro.Covers(1.5, 2.5));
  EXPECT_FALSE(gyro.Covers(2.03, 2.05));
  EXPECT_FALSE(gyro.Covers(-0.1, 1.0));
  EXPECT_FALSE(gyro.Covers(4.0, 5.1));
}

TEST(GyroIntegration, LeavesOutBadSamples) {
  auto recording = Record(HandHeld(), {}, {}, 400.0, 5.0, 1);
  const GyroIntegration whole(recording.imu);
  recording.imu[100].angular_velocity.x() = std::nan("");
  recording.imu.insert(recording.imu.begin() + 300, recording.imu[200]);
  const GyroIntegration mended(recording.imu);
  EXPECT_LT(AngleBetween(whole.RotationBetween(0.0, 5.0), mended.RotationBetween(0.0, 5.0)), 1e-6);
  recording.imu.resize(3);
  EXPECT_THROW(GyroIntegration{recording.imu}, InputError);
}

TEST(SpecificForceIntegration, PredictsPositionsAndVelocities) {
  const test::Rig rig;
  const auto motion = HandHeld();
  const auto recording = Record(motion, rig, {}, 200.0, 10.0, 1);
  const SpecificForceIntegration integration(recording.imu, rig.gyroscope_bias);
  const Eigen::Vector3d g(0.0, 0.0, -9.81);
  const auto velocity_at = [&](double time) {
    return Eigen::Vector3d(motion.position[0].Derivative(time), motion.position[1].Derivative(time),
                           motion.position[2].Derivative(time));
  };
  for (const double t1 : {3.0, 5.021, 1.513}) {
    const double t0 = 3.517, T = t1 - t0;
    const RigidTransform from = motion.T_map_imu(t0);
    const Eigen::Vector3d velocity = velocity_at(t0);
    const Eigen::Vector3d predicted =
        from.translation + T * velocity + 0.5 * T * T * g +
        from.rotation * (integration.Position(t0, t1) -
                         integration.PositionBiasJacobian(t0, t1) * rig.accelerometer_bias);
    EXPECT_LT((predicted - motion.T_map_imu(t1).translation).norm(), 2e-6);
    const Eigen::Vector3d gained =
        T * g + from.rotation * (integration.Velocity(t0, t1) -
                                 integration.VelocityBiasJacobian(t0, t1) * rig.accelerometer_bias);
    EXPECT_LT((velocity + gained - velocity_at(t1)).norm(), 5e-6);
  }
}

TEST(Excitation, FindsNoiseRateAndRest) {
  test::Motion motion = HandHeld();
  auto recording = Record(motion, {}, {1e-3, 1e-2, 0.0, 0.0}, 200.0, 20.0, 3);
  const auto still = Record(test::Motion(), {}, {1e-3, 1e-2, 0.0, 0.0}, 200.0, 5.0, 4);
  for (std::size_t i = 0; i < still.imu.size(); ++i) {
    recording.imu[1000 + i].angular_velocity = still.imu[i].angular_velocity;
    recording.imu[1000 + i].specific_force = still.imu[i].specific_force;
  }
  EXPECT_NEAR(ImuRate(recording.imu), 200.0, 1e-6);
  const ImuNoise noise = EstimateImuNoise(recording.imu);
  EXPECT_NEAR(noise.gyroscope, 1e-3, 1e-4);
  EXPECT_NEAR(noise.accelerometer, 1e-2, 1e-3);
  const auto rests = StaticIntervals(recording.imu, noise);
  ASSERT_EQ(rests.size(), 1u);
  EXPECT_NEAR(rests[0].start, 5.0, 0.6);
  EXPECT_NEAR(rests[0].end, 10.0, 0.6);
  EXPECT_LT((MeanAngularVelocity(recording.imu, rests) - test::Rig().gyroscope_bias).norm(), 2e-3);
}

TEST(Excitation, FindsTheNoiseOfEachAxis) {
  auto recording = Record(HandHeld(), {}, {1e-3, 1e-2, 0.0, 0.0}, 200.0, 20.0, 3);
  const auto shaken = Record(test::Motion(), {}, {1e-3, 1e-1, 0.0, 0.0}, 200.0, 20.0, 4);
  for (std::size_t i = 0; i < recording.imu.size(); ++i) {
    recording.imu[i].specific_force.z() += shaken.imu[i].specific_force.z();
  }
  const double root_rate = std::sqrt(200.0);
  const ImuSigma sigma = SampleSigma(recording.imu, std::nullopt);
  EXPECT_NEAR(sigma.accelerometer.x() / root_rate, 1e-2, 1e-3);
  EXPECT_NEAR(sigma.accelerometer.z() / root_rate, 1e-1, 1e-2);
  EXPECT_NEAR(sigma.gyroscope.z() / root_rate, 1e-3, 1e-4);
  EXPECT_NEAR(EstimateImuNoise(recording.imu).accelerometer, 1e-1, 1e-2);
  // A data sheet speaks of all axes.
  const ImuSigma given = SampleSigma(recording.imu, ImuNoise{2e-3, 3e-2});
  EXPECT_NEAR(given.gyroscope.x(), 2e-3 * root_rate, 1e-9);
  EXPECT_NEAR(given.accelerometer.z(), 3e-2 * root_rate, 1e-9);
}

TEST(Excitation, TellsTurningAboutOneAxis) {
  const Excitation planar = MeasureExcitation(Record(test::Planar(), {}, {}, 100.0, 30.0, 1).imu);
  EXPECT_LT(planar.principal_rms[1], 1e-6);
  EXPECT_GT(planar.principal_rms[2], 0.2);
  EXPECT_NEAR(std::abs(planar.principal_axes(2, 2)), 1.0, 1e-9);
  EXPECT_GT(MeasureExcitation(Record(HandHeld(), {}, {}, 100.0, 30.0, 1).imu).principal_rms[0], 0.3);
}

}  // namespace
}  // namespace mlic::integration_test
