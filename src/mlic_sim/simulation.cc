#include "mlic_sim/simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/imu_simulator.h"
#include "mlic_sim/random_direction.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated recorder.

// Delays from the end of a measurement to the recorder, ns.
constexpr TimeNs kImuDelay = 1000000;
constexpr TimeNs kScanDelay = 4000000;
constexpr TimeNs kImageDelay = 9000000;
// Of the second of two equal IMU samples to the first, ns.
constexpr TimeNs kDoubledAfter = 20000;

struct Job {
  bool is_image;
  std::size_t sensor;  // index among the LiDARs or the cameras
  std::int64_t index;
  double start;     // s, IMU clock: of the scan, or of the image's row 0
  double received;  // s, IMU clock, at the measurement's end; the recorder's delay not included
};

// All scans and images that lie within the drive, in the order in which they end.
std::vector<Job> PlanJobs(const SensorSet& sensors, bool with_images, double duration) {
  std::vector<Job> jobs;
  for (std::size_t l = 0; l < sensors.lidars.size(); ++l) {
    const double period = sensors.lidars[l].model.Period();
    for (std::int64_t k = 0;; ++k) {
      const double start = sensors.lidars[l].phase + period * static_cast<double>(k);
      if (start + period > duration + 1e-9) break;
      jobs.push_back({false, l, k, start, start + period});
    }
  }
  for (std::size_t c = 0; c < sensors.cameras.size(); ++c) {
    const SimulatedCamera& camera = sensors.cameras[c];
    const std::vector<double> times = ImageTimes(camera, duration);
    if (times.empty()) throw InputError("duration: too short for a single image; give some seconds at least");
    for (std::size_t k = 0; with_images && k < times.size(); ++k) {
      const double end = times[k] + camera.readout + 0.5 * camera.exposure;
      jobs.push_back({true, c, static_cast<std::int64_t>(k), times[k], end});
    }
  }
  if (jobs.empty() && !sensors.lidars.empty()) {
    throw InputError("duration: too short for a single scan; give some seconds at least");
  }
  std::stable_sort(jobs.begin(), jobs.end(),
                   [](const auto& a, const auto& b) { return a.received < b.received; });
  return jobs;
}

class Simulator {
 public:
  Simulator(const SensorSet& sensors, const SimulationOptions& options)
      : sensors_(sensors),
        options_(options),
        stage_(std::make_shared<ImageStage>(sensors, options)),
        random_(Random(options.seed).Fork(2)) {
    for (const SimulatedLidar& lidar : sensors.lidars) {
      patterns_.push_back(IsRepeating(lidar.model) ? MakeScanPattern(lidar.model, 0) : std::vector<Firing>());
    }
  }

  const std::shared_ptr<const ImageStage>& stage() const { return stage_; }

  void Run(DriveSink& sink, bool with_images, const CancellationToken& cancellation) {
    const std::vector<Job> jobs = PlanJobs(sensors_, with_images, options_.duration);
    const std::vector<ImuSample> readings = Readings();
    std::size_t next_imu = 0;
    Random of_stamps = random_.Fork(0).Fork(2);
    const auto emit_imu_until = [&](TimeNs received) {
      for (; next_imu < readings.size(); ++next_imu) {
        const TimeNs stamp = TimeFrom(kSimulationEpoch, readings[next_imu].time);
        if (stamp + kImuDelay >= received) break;
        SimulatedImuMessage message{stamp + kImuDelay, Stamped(stamp, &of_stamps), readings[next_imu]};
        message.sample.time += 1e-9 * static_cast<double>(message.stamp - stamp);
        sink.OnImu(message);
        if (sensors_.imu.doubled > 0.0 && of_stamps.Uniform() < sensors_.imu.doubled) {
          message.stamp += kDoubledAfter;
          message.sample.time += 1e-9 * kDoubledAfter;
          sink.OnImu(message);
        }
      }
    };
    for (std::size_t begin = 0; begin < jobs.size();) {
      std::size_t end = begin;
      while (end < jobs.size() && jobs[end].received < jobs[begin].received + 1.0) ++end;
      std::vector<SimulatedScan> scans(end - begin);
      std::vector<SimulatedImage> images(end - begin);
      ParallelFor(end - begin, [&](std::size_t i) {
        if (cancellation.IsCancelled()) return;
        const Job& job = jobs[begin + i];
        if (job.is_image) {
          images[i] = Take(job);
        } else {
          scans[i] = Cast(job);
        }
      });
      cancellation.ThrowIfCancelled();
      for (std::size_t i = 0; i < end - begin; ++i) {
        if (jobs[begin + i].is_image) {
          emit_imu_until(images[i].received);
          sink.OnImage(std::move(images[i]));
        } else {
          emit_imu_until(scans[i].received);
          sink.OnScan(std::move(scans[i]));
        }
      }
      begin = end;
    }
    emit_imu_until(TimeFrom(kSimulationEpoch, options_.duration + 1.0));
  }

 private:
  // Of the IMU, recorded or simulated, at their true times.
  std::vector<ImuSample> Readings() const {
    if (options_.recorded && !options_.recorded->readings.empty()) return options_.recorded->readings;
    ImuSimulator imu(sensors_.imu, options_.with_noise, random_.Fork(0));
    const auto motion = [&](double time) { return stage_->trajectory().StateAt(time); };
    const auto last = static_cast<std::int64_t>(std::floor(options_.duration * sensors_.imu.rate));
    std::vector<ImuSample> readings;
    for (std::int64_t k = 0; k <= last; ++k) {
      readings.push_back(imu.Next(static_cast<double>(k) / sensors_.imu.rate, motion));
    }
    return readings;
  }

  // A sample's time as its driver stamps it.
  TimeNs Stamped(TimeNs time, Random* random) const {
    const SimulatedImu& imu = sensors_.imu;
    if (imu.stamp_jitter > 0.0) {
      time += static_cast<TimeNs>(std::llround(1e9 * imu.stamp_jitter * random->Normal()));
    }
    if (imu.stamp_step <= 0.0) return time;
    const TimeNs step = static_cast<TimeNs>(std::llround(1e9 * imu.stamp_step));
    return time / step * step;
  }

  SimulatedImage Take(const Job& job) const {
    const SimulatedCamera& camera = sensors_.cameras[job.sensor];
    SimulatedImage image;
    image.camera = job.sensor;
    image.received = TimeFrom(kSimulationEpoch, job.received) + kImageDelay;
    image.stamp =
        TimeFrom(kSimulationEpoch, camera.calibration.OnOwnClock(job.start, 0.5 * options_.duration));
    image.pixels = stage_->Render(job.sensor, static_cast<std::size_t>(job.index), job.start);
    return image;
  }

  SimulatedScan Cast(const Job& job) const {
    const SimulatedLidar& lidar = sensors_.lidars[job.sensor];
    const bool repeating = IsRepeating(lidar.model);
    const std::vector<Firing> own =
        repeating ? std::vector<Firing>() : MakeScanPattern(lidar.model, job.index);
    SimulatedScan scan;
    scan.lidar = job.sensor;
    scan.received = TimeFrom(kSimulationEpoch, job.received) + kScanDelay;
    scan.start = TimeFrom(kSimulationEpoch, lidar.calibration.OnOwnClock(job.start, 0.5 * options_.duration));
    scan.stamp = lidar.stamp_at_end ? TimeFrom(scan.start, lidar.model.Period()) : scan.start;
    std::optional<Random> noise;
    if (options_.with_noise) noise = random_.Fork(1 + job.sensor).Fork(static_cast<std::uint64_t>(job.index));
    scan.points = CastScan(stage_->world(), stage_->trajectory(), lidar.calibration.T_imu_sensor, lidar.model,
                           repeating ? patterns_[job.sensor] : own, job.start, noise);
    if (const std::optional<double> drift = lidar.calibration.clock_drift) {
      for (SimulatedPoint& point : scan.points) point.time /= 1.0 + *drift;
    }
    return scan;
  }

  const SensorSet& sensors_;
  const SimulationOptions& options_;
  std::shared_ptr<const ImageStage> stage_;
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
  // Images are rendered when asked for, and not here.
  void OnImage(SimulatedImage) override {}
  Drive Take() { return std::move(drive_); }

 private:
  std::function<void(LidarScan&)> on_scan_;
  Drive drive_;
};

}  // namespace

void Simulate(const SensorSet& sensors, const SimulationOptions& options, DriveSink& sink,
              const CancellationToken& cancellation) {
  Simulator(sensors, options).Run(sink, true, cancellation);
}

Drive SimulateDrive(const SensorSet& sensors, const SimulationOptions& options,
                    const std::function<void(LidarScan&)>& on_scan) {
  DriveCollector collector(sensors, on_scan);
  Simulator simulator(sensors, options);
  simulator.Run(collector, false, {});
  Drive drive = collector.Take();
  for (std::size_t c = 0; c < sensors.cameras.size(); ++c) {
    CameraRecording recording;
    recording.images = MakeRenderedImages(simulator.stage(), c, options.duration);
    recording.width = sensors.cameras[c].intrinsics.width;
    recording.height = sensors.cameras[c].intrinsics.height;
    drive.cameras.push_back(recording);
  }
  return drive;
}

std::vector<SensorCalibration> TrueCalibrations(const SensorSet& sensors) {
  std::vector<SensorCalibration> calibrations;
  for (const SimulatedLidar& lidar : sensors.lidars) {
    calibrations.push_back(AsTheImuSeesIt(sensors.imu, lidar.calibration));
  }
  return calibrations;
}

SensorCalibration AsTheImuSeesIt(const SimulatedImu& imu, SensorCalibration calibration) {
  calibration.time_offset += GroupDelay(imu.gyroscope_low_pass, imu.rate);
  return calibration;
}

Rig RigFromSensorSet(const SensorSet& sensors, const GuessOptions& options) {
  Rig rig;
  rig.imu.topic = sensors.imu.topic;
  rig.imu.frame_id = sensors.imu.frame_id;
  if (sensors.imu.noise.gyroscope > 0.0 && sensors.imu.noise.accelerometer > 0.0)
    rig.imu.noise = sensors.imu.noise;
  rig.imu.intrinsics = sensors.imu.intrinsics;
  Random random = Random(options.seed).Fork(3);
  const auto fill_common = [&](const auto& sensor, auto& config) {
    config.name = sensor.name;
    config.topic = sensor.topic;
    config.frame_id = sensor.frame_id;
    const Eigen::Vector3d axis = RandomDirection(&random), direction = RandomDirection(&random);
    if (!options.with_guess) return;
    ExtrinsicGuess guess;
    const RigidTransform& truth = sensor.calibration.T_imu_sensor;
    guess.T_imu_sensor.rotation =
        (ExpQuaternion(options.rotation_error_deg * M_PI / 180.0 * axis) * truth.rotation).normalized();
    guess.T_imu_sensor.translation = truth.translation + options.translation_error * direction;
    config.guess = guess;
  };
  for (const SimulatedLidar& lidar : sensors.lidars) {
    LidarConfig config;
    fill_common(lidar, config);
    rig.lidars.push_back(config);
  }
  for (const SimulatedCamera& camera : sensors.cameras) {
    CameraConfig config;
    fill_common(camera, config);
    config.model = camera.intrinsics.model;
    config.fov_deg = camera.fov_deg;
    config.shutter = camera.rolling_shutter ? Shutter::kRolling : Shutter::kGlobal;
    rig.cameras.push_back(config);
  }
  return rig;
}

}  // namespace mlic::sim
