#include "mlic_sim/recorded_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/simulation.h"

namespace mlic::sim::recorded_motion_test {
namespace {

constexpr double kRate = 200.0;  // Hz, of the poses

// A hand-held path of some seconds at an odd place, whose clock begins at 5 s.
RecordedMotion Recorded(double duration) {
  const auto motion = MakeTrajectory(Scenario::kHandheld, 3, duration, {});
  RecordedMotion recorded;
  for (int k = 0; k <= static_cast<int>(duration * kRate); ++k) {
    RigidTransform pose = motion->PoseAt(k / kRate);
    pose.translation += Eigen::Vector3d(40.0, -7.0, 12.0);
    if (k % 2 == 1) pose.rotation.coeffs() *= -1.0;
    recorded.path.push_back({5.0 + k / kRate, pose});
  }
  return recorded;
}

TEST(RecordedMotion, TheSplineMovesAsThePathDid) {
  const auto motion = MakeTrajectory(Scenario::kHandheld, 3, 12.0, {});
  const auto found = MakeRecordedTrajectory(Recorded(12.0).path);
  for (double t = 0.5; t < 11.5; t += 0.31) {
    const MotionState expected = motion->StateAt(t), state = found->StateAt(5.0 + t);
    const Eigen::Vector3d shift(40.0, -7.0, 12.0);
    EXPECT_LT((state.T_map_imu.translation - expected.T_map_imu.translation - shift).norm(), 1e-6);
    EXPECT_LT(AngleBetween(state.T_map_imu.rotation, expected.T_map_imu.rotation), 1e-6);
    EXPECT_LT((state.velocity - expected.velocity).norm(), 1e-4);
    EXPECT_LT((state.acceleration - expected.acceleration).norm(), 1e-2);
    EXPECT_LT((state.angular_velocity - expected.angular_velocity).norm(), 1e-3);
  }
}

TEST(RecordedMotion, APartBeginsAtZeroAboutTheOrigin) {
  RecordedMotion whole = Recorded(12.0);
  for (int k = 0; k < 1200; ++k)
    whole.readings.push_back({5.0 + 0.01 * k, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  const RecordedMotion part = PartOf(whole, 4.0, 5.0);
  EXPECT_NEAR(part.path.front().time, -1.0, 1e-9);
  EXPECT_NEAR(part.path.back().time, 6.0, 1e-9);
  ASSERT_EQ(part.readings.size(), 501u);
  EXPECT_NEAR(part.readings.front().time, 0.0, 1e-9);
  EXPECT_NEAR(part.readings.back().time, 5.0, 1e-9);
  Eigen::AlignedBox3d box;
  for (const TimedPose& pose : part.path) box.extend(pose.pose.translation);
  EXPECT_LT(box.center().head<2>().norm(), 1e-9);
  EXPECT_NEAR(box.min().z(), 1.0, 1e-9);
  EXPECT_GE(box.sizes().x(), box.sizes().y());
  // Moved and turned about the vertical as a whole: it turns as before.
  const auto of_part = MakeRecordedTrajectory(part.path), of_whole = MakeRecordedTrajectory(whole.path);
  const MotionState a = of_part->StateAt(2.0), b = of_whole->StateAt(5.0 + 4.0 + 2.0);
  EXPECT_LT((a.angular_velocity - b.angular_velocity).norm(), 1e-4);
  EXPECT_NEAR(a.acceleration.z(), b.acceleration.z(), 1e-3);
}

TEST(RecordedMotion, APathThatIsTooShortIsRefused) {
  EXPECT_THROW(PartOf(Recorded(12.0), 8.0, 5.0), InputError);
  EXPECT_THROW(PartOf({}, 0.0, 5.0), InputError);
  EXPECT_THROW(MakeRecordedTrajectory({}), InputError);
}

TEST(RecordedMotion, AGapOrReadingsOfAnotherTimeAreRefused) {
  RecordedMotion whole = Recorded(12.0);
  whole.readings.push_back({500.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  EXPECT_THROW(PartOf(whole, 4.0, 5.0), InputError);
  whole.path.erase(whole.path.begin() + 1000, whole.path.begin() + 1010);
  EXPECT_THROW(MakeRecordedTrajectory(whole.path), InputError);
}

TEST(RecordedMotion, ADriveHasThePathsScansAndTheReadings) {
  SensorSet sensors;
  sensors.lidars.emplace_back();
  RecordedMotion whole = Recorded(4.0);
  for (int k = 0; k < 400; ++k)
    whole.readings.push_back({5.0 + 0.01 * k, {0.1, 0.2, 0.01 * k}, {0.0, 0.0, 9.8}});
  SimulationOptions options;
  options.scenario = Scenario::kHandheld;
  options.duration = 2.0;
  options.recorded = std::make_shared<RecordedMotion>(PartOf(whole, 1.0, 2.0));
  const Drive drive = SimulateDrive(sensors, options);
  ASSERT_EQ(drive.imu.size(), 201u);
  EXPECT_NEAR(drive.imu[50].time, 0.5, 1e-6);
  EXPECT_NEAR(drive.imu[50].angular_velocity.z(), 0.01 * 150, 1e-9);
  EXPECT_FALSE(drive.lidars.at(0).scans.empty());
  EXPECT_GT(drive.lidars[0].scans[0].points.size(), 100u);
}

}  // namespace
}  // namespace mlic::sim::recorded_motion_test
