#include "mlic_sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/imu_simulator.h"

namespace mlic::sim {
namespace {

// Delays from the end of a measurement to the recorder, ns.
constexpr TimeNs kImuDelay = 1000000;
constexpr TimeNs kScanDelay = 4000000;

struct ScanJob {
  std::size_t lidar;
  std::int64_t index;
  double start;     // s, IMU clock
  double received;  // s, IMU clock, at the scan's end; the recorder's delay not included
};

// All scans that lie within the drive, in the order in which they end.
std::vector<ScanJob> PlanScans(const SensorSet& sensors, double duration) {
  std::vector<ScanJob> jobs;
  for (std::size_t l = 0; l < sensors.lidars.size(); ++l) {
    const double period = sensors.lidars[l].model.Period();
    for (std::int64_t k = 0;; ++k) {
      const double start = sensors.lidars[l].phase + period * static_cast<double>(k);
      if (start + period > duration + 1e-9) break;
      jobs.push_back({l, k, start, start + period});
    }
  }
  if (jobs.empty()) throw InputError("duration: too short for a single scan; give some seconds at least");
  std::stable_sort(jobs.begin(), jobs.end(),
                   [](const auto& a, const auto& b) { return a.received < b.received; });
  return jobs;
}

class Simulator {
 public:
  Simulator(const SensorSet& sensors, const SimulationOptions& options)
      : sensors_(sensors),
        options_(options),
        world_(MakeWorld(options.scenario)),
        trajectory_(MakeTrajectory(sensors, options)),
        random_(Random(options.seed).Fork(2)) {
    for (const SimulatedLidar& lidar : sensors.lidars) {
      patterns_.push_back(IsRepeating(lidar.model) ? MakeScanPattern(lidar.model, 0) : std::vector<Firing>());
    }
  }

  void Run(DriveSink& sink, const CancellationToken& cancellation) {
    const std::vector<ScanJob> jobs = PlanScans(sensors_, options_.duration);
    ImuSimulator imu(sensors_.imu, options_.with_noise, random_.Fork(0));
    const std::int64_t imu_count =
        static_cast<std::int64_t>(std::floor(options_.duration * sensors_.imu.rate)) + 1;
    std::int64_t next_imu = 0;
    const auto emit_imu_until = [&](TimeNs received) {
      for (; next_imu < imu_count; ++next_imu) {
        const double time = static_cast<double>(next_imu) / sensors_.imu.rate;
        const TimeNs stamp = TimeFrom(kSimulationEpoch, time);
        if (stamp + kImuDelay >= received) break;
        sink.OnImu({stamp + kImuDelay, stamp, imu.Next(time, trajectory_->StateAt(time))});
      }
    };
    for (std::size_t begin = 0; begin < jobs.size();) {
      std::size_t end = begin;
      while (end < jobs.size() && jobs[end].received < jobs[begin].received + 1.0) ++end;
      std::vector<SimulatedScan> scans(end - begin);
      ParallelFor(scans.size(), [&](std::size_t i) {
        if (!cancellation.IsCancelled()) scans[i] = Cast(jobs[begin + i]);
      });
      cancellation.ThrowIfCancelled();
      for (SimulatedScan& scan : scans) {
        emit_imu_until(scan.received);
        sink.OnScan(std::move(scan));
      }
      begin = end;
    }
    emit_imu_until(TimeFrom(kSimulationEpoch, options_.duration + 1.0));
  }

 private:
  SimulatedScan Cast(const ScanJob& job) const {
    const SimulatedLidar& lidar = sensors_.lidars[job.lidar];
    const bool repeating = IsRepeating(lidar.model);
    const std::vector<Firing> own =
        repeating ? std::vector<Firing>() : MakeScanPattern(lidar.model, job.index);
    SimulatedScan scan;
    scan.lidar = job.lidar;
    scan.received = TimeFrom(kSimulationEpoch, job.received) + kScanDelay;
    scan.start = TimeFrom(kSimulationEpoch, job.start - lidar.calibration.time_offset);
    scan.stamp = lidar.stamp_at_end ? TimeFrom(scan.start, lidar.model.Period()) : scan.start;
    scan.points = CastScan(*world_, *trajectory_, lidar.calibration.T_imu_sensor, lidar.model,
                           repeating ? patterns_[job.lidar] : own, job.start, options_.with_noise,
                           random_.Fork(1 + job.lidar).Fork(static_cast<std::uint64_t>(job.index)));
    return scan;
  }

  const SensorSet& sensors_;
  const SimulationOptions& options_;
  std::unique_ptr<World> world_;
  std::unique_ptr<Trajectory> trajectory_;
  Random random_;
  std::vector<std::vector<Firing>> patterns_;  // of the LiDARs that repeat theirs
};

class DriveCollector : public DriveSink {
 public:
  DriveCollector(const SensorSet& sensors, const std::function<void(LidarScan&)>& on_scan)
      : on_scan_(on_scan) {
    drive_.epoch = kSimulationEpoch;
    for (const SimulatedLidar& lidar : sensors.lidars) {
      drive_.lidars.emplace_back();
      drive_.lidars.back().scan_period = lidar.model.Period();
    }
  }
  void OnImu(const SimulatedImuMessage& message) override { drive_.imu.push_back(message.sample); }
  void OnScan(SimulatedScan scan) override {
    LidarScan stored;
    stored.time = SecondsSince(kSimulationEpoch, scan.start);
    for (const SimulatedPoint& p : scan.points) {
      if (p.returned) stored.points.push_back({p.position, static_cast<float>(p.time), p.intensity, p.ring});
    }
    if (on_scan_) on_scan_(stored);
    stored.points.shrink_to_fit();
    drive_.lidars[scan.lidar].scans.push_back(std::move(stored));
  }
  Drive Take() { return std::move(drive_); }

 private:
  std::function<void(LidarScan&)> on_scan_;
  Drive drive_;
};

Eigen::Vector3d RandomDirection(Random& random) {
  const double x = random.Normal(), y = random.Normal(), z = random.Normal();
  return Eigen::Vector3d(x, y, z).normalized();
}

}  // namespace

std::unique_ptr<World> MakeWorld(Scenario scenario) {
  if (scenario == Scenario::kHandheld) return MakeHall();
  return MakeYard(scenario == Scenario::kPlanar || scenario == Scenario::kCircle);
}

std::unique_ptr<Trajectory> MakeTrajectory(const SensorSet& sensors, const SimulationOptions& options) {
  return MakeTrajectory(options.scenario, options.seed, options.duration, sensors.imu.T_body_imu);
}

void Simulate(const SensorSet& sensors, const SimulationOptions& options, DriveSink& sink,
              const CancellationToken& cancellation) {
  Simulator(sensors, options).Run(sink, cancellation);
}

Drive SimulateDrive(const SensorSet& sensors, const SimulationOptions& options,
                    const std::function<void(LidarScan&)>& on_scan) {
  DriveCollector collector(sensors, on_scan);
  Simulate(sensors, options, collector);
  return collector.Take();
}

std::vector<SensorCalibration> TrueCalibrations(const SensorSet& sensors) {
  std::vector<SensorCalibration> calibrations;
  for (const SimulatedLidar& lidar : sensors.lidars) calibrations.push_back(lidar.calibration);
  return calibrations;
}

Rig RigFromSensorSet(const SensorSet& sensors, const GuessOptions& options) {
  Rig rig;
  rig.imu.topic = sensors.imu.topic;
  rig.imu.frame_id = sensors.imu.frame_id;
  if (sensors.imu.noise.gyroscope > 0.0 && sensors.imu.noise.accelerometer > 0.0)
    rig.imu.noise = sensors.imu.noise;
  rig.imu.intrinsics = sensors.imu.intrinsics;
  Random random = Random(options.seed).Fork(3);
  for (const SimulatedLidar& lidar : sensors.lidars) {
    LidarConfig config;
    config.name = lidar.name;
    config.topic = lidar.topic;
    config.frame_id = lidar.frame_id;
    const Eigen::Vector3d axis = RandomDirection(random), direction = RandomDirection(random);
    if (options.with_guess) {
      ExtrinsicGuess guess;
      const RigidTransform& truth = lidar.calibration.T_imu_sensor;
      guess.T_imu_sensor.rotation =
          (ExpQuaternion(options.rotation_error_deg * M_PI / 180.0 * axis) * truth.rotation).normalized();
      guess.T_imu_sensor.translation = truth.translation + options.translation_error * direction;
      config.guess = guess;
    }
    rig.lidars.push_back(config);
  }
  return rig;
}

}  // namespace mlic::sim
