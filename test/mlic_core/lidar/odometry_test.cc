#include "mlic_core/lidar/odometry.h"

#include <gtest/gtest.h>

#include "mlic_core/common/error.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/lidar/deskew.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_core/lidar/voxel_hash_map.h"
#include "mlic_sim/hall.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/lidar_scanner.h"
#include "mlic_sim/simulation.h"
#include "support/source_directory.h"

namespace mlic::odometry_test {
namespace {

constexpr double kDegree = M_PI / 180.0;

// What one LiDAR of a simulated drive recorded, and where it truly was at times of its own clock.
struct SimulatedRecording {
  LidarRecording recording;
  std::function<RigidTransform(double time)> truth;
};

SimulatedRecording Record(const std::string& sensors, sim::Scenario scenario, double duration,
                          std::size_t lidar) {
  sim::SensorSet set = sim::LoadSensorSet(SourceDirectory() + "/config/simulation/" + sensors);
  set.lidars = {set.lidars[lidar]};
  sim::SimulationOptions options;
  options.scenario = scenario;
  options.duration = duration;
  SimulatedRecording result;
  result.recording = sim::SimulateDrive(set, options, [](LidarScan& scan) { FilterScan(scan); }).lidars[0];
  const std::shared_ptr<sim::Trajectory> trajectory = sim::MakeTrajectory(set, options);
  const SensorCalibration calibration = set.lidars[0].calibration;
  result.truth = [trajectory, calibration](double time) {
    return trajectory->PoseAt(time + calibration.time_offset) * calibration.T_imu_sensor;
  };
  return result;
}

// Root mean square errors of the motion over one second.
struct Errors {
  double translation = 0.0;  // m
  double rotation = 0.0;     // rad
};

Errors ErrorsOver(const SimulatedRecording& data, const std::vector<TimedPose>& poses,
                  std::size_t scans = 10) {
  Errors errors;
  std::size_t count = 0;
  for (std::size_t i = 0; i + scans < poses.size(); ++i, ++count) {
    const TimedPose& from = poses[i];
    const TimedPose& to = poses[i + scans];
    const RigidTransform truth = data.truth(from.time).Inverse() * data.truth(to.time);
    const RigidTransform error = truth.Inverse() * (from.pose.Inverse() * to.pose);
    errors.translation += error.translation.squaredNorm();
    errors.rotation += Log(error.rotation).squaredNorm();
  }
  errors.translation = std::sqrt(errors.translation / count);
  errors.rotation = std::sqrt(errors.rotation / count);
  return errors;
}

std::vector<TimedPose> RunOn(const LidarRecording& recording, const InertialMotion& inertial = {},
                             std::size_t remembered = kAllScans) {
  return RunOdometry(recording, inertial, remembered, CancellationToken(), nullptr);
}

// What an IMU without errors says of the rotation.
InertialMotion TrueRotation(const SimulatedRecording& data) {
  InertialMotion inertial;
  inertial.rotation = [&](double from, double to) {
    return data.truth(from).rotation.conjugate() * data.truth(to).rotation;
  };
  return inertial;
}

TEST(ScanMotion, AgreesWithTheExponentialAtFastTurns) {
  const Twist twist{Eigen::Vector3d(3.0, -6.0, 5.0), Eigen::Vector3d(1.0, 2.0, -3.0)};
  const Eigen::Vector3d acceleration(20.0, 10.0, -5.0);
  ScanMotion motion(twist, acceleration, 0.05);
  motion.SetLinear(twist.linear);
  const Eigen::Vector3d p(7.0, -3.0, 2.0);
  for (const double s : {-0.05, -0.0312, 0.0, 0.0007, 0.05}) {
    const Eigen::Vector3d exact =
        ExpMatrix(s * twist.angular + 0.5 * s * s * acceleration) * p + s * twist.linear;
    EXPECT_LT((motion.ToMiddle(p, s) - exact).norm(), 1e-4 * p.norm()) << s;
  }
}

TEST(VoxelHashMap, FindsThePlaneAndNothingElsewhere) {
  Random random(3);
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.3, 1.0).normalized();
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 20000; ++i) {
    Eigen::Vector3d p(random.Uniform(-5.0, 5.0), random.Uniform(-5.0, 5.0), random.Uniform(-5.0, 5.0));
    p -= (normal.dot(p) - 0.4 - 0.01 * random.Normal()) * normal;
    points.push_back(p);
  }
  VoxelHashMap map(1.0);
  map.Add(points);
  const Eigen::Vector3d on_plane = 0.4 * normal;
  const Surface* surface = map.Find(on_plane);
  ASSERT_NE(surface, nullptr);
  ASSERT_EQ(surface->kind, Surface::Kind::kPlane);
  EXPECT_GT(std::abs(surface->normal.dot(normal)), std::cos(1.0 * kDegree));
  EXPECT_NEAR(surface->normal.dot(on_plane - surface->mean), 0.0, 3e-3);
  EXPECT_EQ(map.Find(on_plane + 4.0 * normal), nullptr);
  map.RemoveFarFrom(Eigen::Vector3d(100.0, 0.0, 0.0), 10.0);
  EXPECT_EQ(map.size(), 0u);
}

TEST(LidarOdometry, FollowsAHandHeldSpinningLidar) {
  const SimulatedRecording data = Record("handheld.yaml", sim::Scenario::kHandheld, 8.0, 0);
  const std::vector<TimedPose> poses = RunOn(data.recording);
  ASSERT_EQ(poses.size(), data.recording.scans.size());
  EXPECT_LT(Log(poses.front().pose.rotation).norm(), 1e-12);
  const Errors errors = ErrorsOver(data, poses);
  EXPECT_LT(errors.translation, 0.01);
  EXPECT_LT(errors.rotation, 0.15 * kDegree);
}

TEST(LidarOdometry, TheGyroscopeMakesItMorePrecise) {
  const SimulatedRecording data = Record("handheld.yaml", sim::Scenario::kHandheld, 6.0, 0);
  const Errors without = ErrorsOver(data, RunOn(data.recording));
  const Errors with = ErrorsOver(data, RunOn(data.recording, TrueRotation(data)));
  EXPECT_LT(with.rotation, 0.5 * without.rotation);
  EXPECT_LT(with.rotation, 0.03 * kDegree);
  EXPECT_LT(with.translation, 0.006);
}

// Scans that show nothing for 1.2 s: the velocity there comes from the accelerometer.
TEST(LidarOdometry, TheAccelerometerBridgesBlindScans) {
  SimulatedRecording data = Record("handheld.yaml", sim::Scenario::kHandheld, 6.0, 0);
  constexpr std::size_t kFirst = 30, kLast = 42;
  for (std::size_t i = kFirst; i < kLast; ++i) data.recording.scans[i].points.clear();
  InertialMotion inertial = TrueRotation(data);
  const auto velocity = [&](double time) -> Eigen::Vector3d {
    return (data.truth(time + 1e-3).translation - data.truth(time - 1e-3).translation) / 2e-3;
  };
  inertial.gravity = Eigen::Vector3d(0.3, -2.0, 9.6);
  const Eigen::Vector3d in_map = data.truth(data.recording.scans[0].time + 0.05).rotation * inertial.gravity;
  inertial.gain = [&, in_map](double from, double to) {
    const Eigen::Quaterniond to_lidar = data.truth(from).rotation.conjugate();
    const double T = to - from;
    const Eigen::Vector3d moved = data.truth(to).translation - data.truth(from).translation;
    LinearGain gain;
    gain.velocity = to_lidar * (velocity(to) - velocity(from) - T * in_map);
    gain.position = to_lidar * (moved - T * velocity(from) - 0.5 * T * T * in_map);
    return gain;
  };
  const auto error_across = [&](const std::vector<TimedPose>& poses) {
    const TimedPose &from = poses[kFirst - 1], &to = poses[kLast - 1];
    const RigidTransform truth = data.truth(from.time).Inverse() * data.truth(to.time);
    return (truth.Inverse() * (from.pose.Inverse() * to.pose)).translation.norm();
  };
  const double without = error_across(RunOn(data.recording, TrueRotation(data)));
  const double with = error_across(RunOn(data.recording, inertial));
  std::printf("blind for 1.2 s: %.3f m off, with the accelerometer %.3f m\n", without, with);
  EXPECT_GT(without, 0.3);
  EXPECT_LT(with, 0.05);
}

// Followed as well, but for a drift that grows.
TEST(LidarOdometry, FollowsInAMapOfFewScans) {
  const SimulatedRecording data = Record("dual_rosette.yaml", sim::Scenario::kHandheld, 8.0, 0);
  const Errors errors = ErrorsOver(data, RunOn(data.recording, {}, 20));
  EXPECT_LT(errors.translation, 0.04);
  EXPECT_LT(errors.rotation, 0.2 * kDegree);
}

// A trajectory that stands still at first and then sets out within a second.
class SettingOut : public sim::Trajectory {
 public:
  SettingOut(std::unique_ptr<sim::Trajectory> motion, double standing)
      : motion_(std::move(motion)), standing_(standing) {}
  RigidTransform PoseAt(double time) const override {
    const double after = std::max(0.0, time - standing_);
    return motion_->PoseAt(after < 1.0 ? 0.5 * after * after : after - 0.5);
  }
  sim::MotionState StateAt(double) const override { throw InternalError("not needed"); }

 private:
  std::unique_ptr<sim::Trajectory> motion_;
  double standing_;  // s
};

// A sparse LiDAR that stands for a while: its map must not fill with the same few lines.
TEST(LidarOdometry, SetsOutAfterAStand) {
  constexpr double kStanding = 8.0, kPeriod = 0.1;
  sim::LidarModel model;
  model.rings = 16;
  model.vertical_fov_deg[0] = -15.0;
  model.vertical_fov_deg[1] = 15.0;
  model.range_noise = 0.03;
  const SettingOut trajectory(sim::MakeTrajectory(sim::Scenario::kHandheld, 48, 20.0, RigidTransform()),
                              kStanding);
  const auto world = sim::MakeHall();
  const std::vector<sim::Firing> firings = sim::MakeScanPattern(model, 0);
  LidarRecording recording;
  for (int i = 0; i < 110; ++i) {
    LidarScan scan;
    scan.time = i * kPeriod;
    for (const sim::SimulatedPoint& simulated :
         sim::CastScan(*world, trajectory, RigidTransform(), model, firings, scan.time, Random(i))) {
      if (!simulated.returned) continue;
      LidarPoint point;
      point.position = simulated.position;
      point.time = static_cast<float>(simulated.time);
      scan.points.push_back(point);
    }
    FilterScan(scan);
    recording.scans.push_back(std::move(scan));
  }
  const std::vector<TimedPose> poses = RunOn(recording);
  const RigidTransform truth =
      trajectory.PoseAt(poses.front().time).Inverse() * trajectory.PoseAt(poses.back().time);
  const RigidTransform& end = poses.back().pose;
  EXPECT_LT((end.translation - truth.translation).norm(), 0.05);
  EXPECT_LT(AngleBetween(end.rotation, truth.rotation), 0.5 * kDegree);
}

// An IMU that starts late, and one that was lost for a while.
TEST(LidarOdometry, GoesOnWithoutTheGyroscopeWhereItIsMissing) {
  const SimulatedRecording data = Record("handheld.yaml", sim::Scenario::kHandheld, 6.0, 0);
  InertialMotion inertial;
  inertial.rotation = [&](double from, double to) -> std::optional<Eigen::Quaterniond> {
    if (from < 2.0 || (from < 4.0 && to > 3.5)) return std::nullopt;
    return data.truth(from).rotation.conjugate() * data.truth(to).rotation;
  };
  const Errors errors = ErrorsOver(data, RunOn(data.recording, inertial));
  EXPECT_LT(errors.translation, 0.01);
  EXPECT_LT(errors.rotation, 0.15 * kDegree);
}

TEST(LidarOdometry, FollowsASolidStateLidarOnACar) {
  const SimulatedRecording data = Record("paper_rig_lidars.yaml", sim::Scenario::kFigureEight, 10.0, 1);
  const Errors errors = ErrorsOver(data, RunOn(data.recording));
  EXPECT_LT(errors.translation, 0.03);
  EXPECT_LT(errors.rotation, 0.15 * kDegree);
}

TEST(LidarOdometry, FollowsAHandHeldRosette) {
  const SimulatedRecording data = Record("dual_rosette.yaml", sim::Scenario::kHandheld, 8.0, 0);
  const Errors errors = ErrorsOver(data, RunOn(data.recording));
  EXPECT_LT(errors.translation, 0.04);
  EXPECT_LT(errors.rotation, 0.2 * kDegree);
}

TEST(LidarOdometry, GivesTheSameBytesAgain) {
  const SimulatedRecording data = Record("dual_rosette.yaml", sim::Scenario::kHandheld, 2.0, 1);
  const std::vector<TimedPose> first = RunOn(data.recording);
  const std::vector<TimedPose> second = RunOn(data.recording);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].pose.translation, second[i].pose.translation);
    EXPECT_EQ(first[i].pose.rotation.coeffs(), second[i].pose.rotation.coeffs());
  }
}

TEST(LidarOdometry, SurvivesEmptyScansAndGaps) {
  SimulatedRecording data = Record("handheld.yaml", sim::Scenario::kHandheld, 5.0, 0);
  data.recording.scans[20].points.clear();
  data.recording.scans.erase(data.recording.scans.begin() + 30, data.recording.scans.begin() + 32);
  const std::vector<TimedPose> poses = RunOn(data.recording);
  const RigidTransform truth = data.truth(poses.front().time).Inverse() * data.truth(poses.back().time);
  EXPECT_LT((poses.back().pose.translation - truth.translation).norm(), 0.05);
}

TEST(LidarOdometry, LostTrackingIsNeverNan) {
  SimulatedRecording data = Record("handheld.yaml", sim::Scenario::kHandheld, 4.0, 0);
  Random random(7);
  for (std::size_t i = 20; i < data.recording.scans.size(); ++i) {
    for (LidarPoint& point : data.recording.scans[i].points) {
      for (int axis = 0; axis < 3; ++axis) {
        point.position[axis] = static_cast<float>(random.Uniform(-300.0, 300.0));
      }
    }
  }
  const std::vector<TimedPose> poses = RunOn(data.recording);
  for (const TimedPose& pose : poses) {
    EXPECT_TRUE(pose.pose.translation.allFinite());
    EXPECT_TRUE(pose.pose.rotation.coeffs().allFinite());
  }
}

TEST(LidarOdometry, StopsWhenCancelled) {
  LidarRecording recording;
  recording.scans.resize(3);
  CancellationToken cancellation;
  cancellation.Cancel();
  EXPECT_THROW(RunOdometry(recording, {}, kAllScans, cancellation, nullptr), Cancelled);
}

TEST(LidarOdometry, NoScansGiveNoPoses) { EXPECT_TRUE(RunOn(LidarRecording()).empty()); }

}  // namespace
}  // namespace mlic::odometry_test
