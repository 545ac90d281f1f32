#include "mlic_core/initialization/camera_rotation.h"

#include <gtest/gtest.h>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::camera_rotation_test {
namespace {

constexpr double kDuration = 12.0, kOffset = 0.025;  // s

// A long bend: the rate of turn changes by at most 0.04 rad/s^2.
SplitSpline Bend() {
  const UniformKnots knots = UniformKnots::Covering(0.0, kDuration, 0.05);
  std::vector<Eigen::Quaterniond> rotations;
  for (int j = 0; j < knots.count; ++j) {
    const double t = knots.ControlPointTime(j), period = 10.0 / (2.0 * M_PI);
    rotations.push_back(
        FromRollPitchYaw({0.0, 0.0, 0.3 * t - 0.04 * period * period * std::sin(t / period)}));
  }
  const std::vector<Eigen::Vector3d> positions(knots.count, Eigen::Vector3d::Zero());
  return {So3Spline(knots, rotations), PositionSpline(knots, positions)};
}

std::vector<VisualMotion> MotionsOf(const SplitSpline& trajectory, const Eigen::Quaterniond& R_imu_camera) {
  constexpr double kStep = 0.35, kNoise = 0.003;  // s, rad
  std::vector<VisualMotion> motions;
  Random random(3);
  for (double a = 0.1; a + kStep + 0.1 < kDuration; a += kStep) {
    const double b = a + kStep;
    const Eigen::Quaterniond turn =
        trajectory.rotation.Rotation(a + kOffset).conjugate() * trajectory.rotation.Rotation(b + kOffset);
    const double x = random.Normal(), y = random.Normal(), z = random.Normal();
    const Eigen::Vector3d noise = kNoise * Eigen::Vector3d(x, y, z);
    VisualMotion& motion = motions.emplace_back();
    motion.time_a = a;
    motion.time_b = b;
    motion.R_a_b = (R_imu_camera.conjugate() * turn * R_imu_camera * ExpQuaternion(noise)).toRotationMatrix();
  }
  return motions;
}

// Another vehicle crosses the view at the start: an offset that puts these images before the first sample of
// the IMU must not look better for it.
TEST(CameraRotation, OffsetsGainNothingByLeavingOutMotionsThatDisagree) {
  const SplitSpline trajectory = Bend();
  ExtrinsicGuess guess;
  guess.T_imu_sensor.rotation = FromRollPitchYaw(Eigen::Vector3d(-81.4, 11.4, 117.7) * M_PI / 180.0);
  guess.sigma_rotation.setConstant(5.0 * M_PI / 180.0);
  std::vector<VisualMotion> motions = MotionsOf(trajectory, guess.T_imu_sensor.rotation);
  for (VisualMotion& seen : motions) {
    if (seen.time_a < 1.0) seen.R_a_b = seen.R_a_b * ExpMatrix({0.0, 0.3, 0.0});
  }
  const CameraRotation found = AlignCameraRotation(motions, {&trajectory}, guess, std::nullopt);
  ASSERT_TRUE(found.valid);
  EXPECT_NEAR(found.time_offset, kOffset, 0.1);
}

}  // namespace
}  // namespace mlic::camera_rotation_test
