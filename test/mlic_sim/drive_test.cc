#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_sim/hall.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/simulation.h"

namespace mlic::sim::drive_test {
namespace {

SensorSet TwoLidars() {
  SensorSet set;
  set.imu.T_body_imu.translation << 0, 0, 1.5;
  set.imu.noise = {1e-3, 1e-2};
  for (int i = 0; i < 2; ++i) {
    SimulatedLidar lidar;
    lidar.name = "lidar" + std::to_string(i);
    lidar.model.rings = 8;
    lidar.model.azimuth_steps = 200;
    lidar.calibration.time_offset = i == 0 ? 0.05 : -0.03;
    lidar.calibration.T_imu_sensor = {FromRollPitchYaw({0.1 * i, 0.2, -0.3}),
                                      Eigen::Vector3d(0.1, 0.2, 0.3 * i)};
    lidar.phase = 0.021 * (i + 1);
    set.lidars.push_back(lidar);
  }
  return set;
}

SimulationOptions Short(Scenario scenario, bool with_noise = true) {
  SimulationOptions options;
  options.scenario = scenario;
  options.duration = 2.0;
  options.with_noise = with_noise;
  return options;
}

// Adds up everything that a drive holds, bit by bit.
std::uint64_t Fingerprint(const Drive& drive) {
  std::uint64_t hash = 1469598103934665603ull;
  const auto add = [&](const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211ull;
  };
  for (const ImuSample& s : drive.imu) {
    add(&s.time, sizeof s.time);
    add(s.angular_velocity.data(), 3 * sizeof(double));
    add(s.specific_force.data(), 3 * sizeof(double));
  }
  for (const LidarRecording& recording : drive.lidars) {
    for (const LidarScan& scan : recording.scans) {
      add(&scan.time, sizeof scan.time);
      for (const LidarPoint& p : scan.points) {
        add(p.position.data(), 3 * sizeof(float));
        add(&p.time, sizeof p.time);
        add(&p.intensity, sizeof p.intensity);
        add(&p.ring, sizeof p.ring);
      }
    }
  }
  return hash;
}

TEST(Simulate, SameSeedSameBytesWhateverTheThreads) {
  const SensorSet set = TwoLidars();
  SimulationOptions options = Short(Scenario::kFigureEight);
  const std::uint64_t expected = Fingerprint(SimulateDrive(set, options));
  {
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(Fingerprint(SimulateDrive(set, options)), expected);
  }
  options.seed = 2;
  EXPECT_NE(Fingerprint(SimulateDrive(set, options)), expected);
}

TEST(Simulate, MessagesComeInOrderOfReceptionAndScansAreComplete) {
  struct Order : DriveSink {
    TimeNs last = 0;
    int imu = 0, scans = 0;
    void OnImu(const SimulatedImuMessage& m) override {
      EXPECT_GE(m.received, last);
      last = m.received, ++imu;
    }
    void OnScan(SimulatedScan scan) override {
      EXPECT_GE(scan.received, last);
      EXPECT_EQ(scan.points.size(), 1600u);
      last = scan.received, ++scans;
    }
    void OnImage(SimulatedImage) override { ADD_FAILURE() << "no cameras in the set"; }
  } order;
  Simulate(TwoLidars(), Short(Scenario::kStatic), order);
  EXPECT_EQ(order.imu, 401);
  EXPECT_EQ(order.scans, 38);
}

TEST(Simulate, DriversStampBadly) {
  SensorSet set = TwoLidars();
  const SimulationOptions options = Short(Scenario::kHandheld);
  const Drive plain = SimulateDrive(set, options);
  set.imu.doubled = 0.5;
  set.imu.stamp_step = 1e-3;
  set.imu.stamp_jitter = 5e-4;
  const Drive bad = SimulateDrive(set, options);
  EXPECT_NEAR(static_cast<double>(bad.imu.size()) / static_cast<double>(plain.imu.size()), 1.5, 0.1);
  std::size_t k = 0;
  double squares = 0.0;
  for (const ImuSample& sample : bad.imu) {
    if (sample.angular_velocity != plain.imu[k].angular_velocity) ++k;
    ASSERT_LT(k, plain.imu.size());
    ASSERT_EQ(sample.angular_velocity, plain.imu[k].angular_velocity);
    squares += std::pow(sample.time - plain.imu[k].time, 2) / static_cast<double>(bad.imu.size());
  }
  // Rounding down to whole milliseconds adds an error of its own of half a step.
  EXPECT_NEAR(std::sqrt(squares), std::sqrt(2.5e-7 + 2.5e-7 + 1e-6 / 12.0), 1e-4);
}

TEST(Simulate, ClockOffsetsShiftTheStampsOnly) {
  const SensorSet shifted = TwoLidars();
  SensorSet plain = shifted;
  for (SimulatedLidar& lidar : plain.lidars) lidar.calibration.time_offset = 0.0;
  const Drive a = SimulateDrive(shifted, Short(Scenario::kHandheld)),
              b = SimulateDrive(plain, Short(Scenario::kHandheld));
  for (std::size_t l = 0; l < 2; ++l) {
    ASSERT_EQ(a.lidars[l].scans.size(), b.lidars[l].scans.size());
    for (std::size_t k = 0; k < a.lidars[l].scans.size(); ++k) {
      // t_imu = t_sensor + time_offset
      EXPECT_NEAR(a.lidars[l].scans[k].time + shifted.lidars[l].calibration.time_offset,
                  b.lidars[l].scans[k].time, 1e-9);
      EXPECT_EQ(a.lidars[l].scans[k].points[7].position, b.lidars[l].scans[k].points[7].position);
    }
  }
}

TEST(Simulate, ADriftingClockStretchesStampsAndPointTimes) {
  SensorSet set = TwoLidars();
  const SimulationOptions options = Short(Scenario::kHandheld);
  const Drive plain = SimulateDrive(set, options);
  const SensorCalibration constant = set.lidars[1].calibration;
  SensorCalibration& drifting = set.lidars[1].calibration;
  drifting.clock_drift = 1e-3;
  const Drive drive = SimulateDrive(set, options);
  const double middle = 0.5 * options.duration;
  ASSERT_EQ(drive.lidars[1].scans.size(), plain.lidars[1].scans.size());
  for (std::size_t k = 0; k < drive.lidars[1].scans.size(); ++k) {
    const LidarScan &a = drive.lidars[1].scans[k], &b = plain.lidars[1].scans[k];
    EXPECT_EQ(drive.lidars[0].scans[k].time, plain.lidars[0].scans[k].time);
    const auto later = [](const LidarScan& scan) { return scan.time + scan.points.back().time; };
    EXPECT_NEAR(drifting.OnImuClock(a.time, middle), constant.OnImuClock(b.time, middle), 1e-9);
    EXPECT_NEAR(drifting.OnImuClock(later(a), middle), constant.OnImuClock(later(b), middle), 3e-8);
    EXPECT_EQ(a.points[7].position, b.points[7].position);
  }
}

TEST(Simulate, NoiseFreeDriveIsConsistentWithItsTruth) {
  const SensorSet set = TwoLidars();
  const SimulationOptions options = Short(Scenario::kHandheld, false);
  const Drive drive = SimulateDrive(set, options);
  const auto trajectory = MakeTrajectory(set, options);
  for (const ImuSample& s : drive.imu) {
    const MotionState state = trajectory->StateAt(s.time);
    EXPECT_EQ((s.angular_velocity - state.angular_velocity).norm(), 0.0);
    const Eigen::Vector3d force =
        state.T_map_imu.rotation.conjugate() * (state.acceleration + Eigen::Vector3d(0, 0, 9.81));
    EXPECT_LT((s.specific_force - force).norm(), 1e-12);
  }
  // Seen again from the true poses at the points' own times, every point is on the first surface of its ray.
  // Times are floats in memory (some ns), so that the few rays that graze an edge may see past it.
  const auto world = MakeHall();
  const std::vector<SensorCalibration> truth = TrueCalibrations(set);
  int seen = 0, agree = 0;
  for (std::size_t l = 0; l < 2; ++l) {
    for (const LidarScan& scan : drive.lidars[l].scans) {
      for (std::size_t i = 0; i < scan.points.size(); i += 7) {
        const LidarPoint& p = scan.points[i];
        const RigidTransform T =
            trajectory->PoseAt(scan.time + p.time + truth[l].time_offset) * truth[l].T_imu_sensor;
        const Eigen::Vector3d ray = T.rotation * p.position.cast<double>().normalized();
        const auto hit = world->Cast(T.translation, ray, 200.0);
        ++seen;
        agree += hit && std::abs(hit->range - p.position.norm()) < 1e-5;
      }
    }
  }
  EXPECT_GT(seen, 5000);
  EXPECT_GT(agree, 0.999 * seen);
}

TEST(RigFromSensorSet, GuessHasExactlyTheStatedErrors) {
  const SensorSet set = TwoLidars();
  GuessOptions options;
  const Rig rig = RigFromSensorSet(set, options);
  ASSERT_EQ(rig.lidars.size(), 2u);
  for (std::size_t l = 0; l < 2; ++l) {
    const RigidTransform& guess = rig.lidars[l].guess->T_imu_sensor;
    const RigidTransform& truth = set.lidars[l].calibration.T_imu_sensor;
    EXPECT_NEAR(AngleBetween(guess.rotation, truth.rotation) * 180 / M_PI, 4.81, 1e-9);
    EXPECT_NEAR((guess.translation - truth.translation).norm(), 0.1, 1e-12);
    EXPECT_FALSE(rig.lidars[l].time_offset.has_value());
  }
  options.with_guess = false;
  EXPECT_FALSE(RigFromSensorSet(set, options).lidars[0].guess.has_value());
}

}  // namespace
}  // namespace mlic::sim::drive_test
