// Errors and time of the calibration after each of its stages, on simulated drives with truth:
//   calibration_benchmark [SECONDS [SEEDS]]        (from the repository root; 30 s of each drive, seed 1
//   only)
// hand-eye: what odometry and initialisation find; single LiDAR: after the plane adjustment of each LiDAR by
// itself; joint: the result. A rig of one LiDAR has no single-LiDAR stage of its own. Errors are those of the
// worst sensor (or pair) in the median of the seeds; seconds count from the loaded drive.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_core/pipeline/joint_adjustment.h"
#include "mlic_core/pipeline/lidar_adjustment.h"
#include "mlic_sim/simulation.h"

namespace mlic {
namespace {

using Clock = std::chrono::steady_clock;

struct Case {
  const char* name;
  const char* sensors;
  sim::Scenario scenario;
  bool with_guess;
};

// Degrees, millimetres, milliseconds; the worst sensor or pair. Height over the IMU is left out of
// imu_translation: a vehicle on the ground does not show it.
struct Errors {
  double imu_rotation = 0.0, imu_translation = 0.0, time_offset = 0.0;
  double pair_rotation = 0.0, pair_translation = 0.0;
  double seconds = 0.0;
};

double Degrees(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return Log(a * b.conjugate()).norm() * 180.0 / M_PI;
}

Errors ErrorsOf(const std::vector<SensorCalibration>& found, const std::vector<SensorCalibration>& truth,
                bool height_shown) {
  Errors e;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const RigidTransform &a = found[i].T_imu_sensor, &b = truth[i].T_imu_sensor;
    const Eigen::Vector3d translation = a.translation - b.translation;
    e.imu_rotation = std::max(e.imu_rotation, Degrees(a.rotation, b.rotation));
    e.imu_translation =
        std::max(e.imu_translation, 1e3 * (height_shown ? translation.norm() : translation.head<2>().norm()));
    e.time_offset = std::max(e.time_offset, 1e3 * std::abs(found[i].time_offset - truth[i].time_offset));
    for (std::size_t k = 0; k < i; ++k) {
      const RigidTransform p = found[k].T_imu_sensor.Inverse() * a;
      const RigidTransform q = truth[k].T_imu_sensor.Inverse() * b;
      e.pair_rotation = std::max(e.pair_rotation, Degrees(p.rotation, q.rotation));
      e.pair_translation = std::max(e.pair_translation, 1e3 * (p.translation - q.translation).norm());
    }
  }
  return e;
}

Dataset Simulated(const sim::SensorSet& sensors, const sim::SimulationOptions& options) {
  Dataset dataset;
  dataset.drives.push_back(sim::SimulateDrive(sensors, options, [](LidarScan& scan) { FilterScan(scan); }));
  return dataset;
}

// Errors after hand-eye, single-LiDAR and joint adjustment.
std::vector<Errors> RunOnce(const Case& test, double duration, std::uint64_t seed) {
  const sim::SensorSet sensors = sim::LoadSensorSet(std::string("config/simulation/") + test.sensors);
  sim::SimulationOptions options;
  options.scenario = test.scenario;
  options.duration = duration;
  options.seed = seed;
  const Dataset dataset = Simulated(sensors, options);
  sim::GuessOptions guess;
  guess.with_guess = test.with_guess;
  guess.seed = seed;
  const Rig rig = sim::RigFromSensorSet(sensors, guess);
  const std::vector<SensorCalibration> truth = sim::TrueCalibrations(sensors);
  const CancellationToken never;
  CalibrationObserver nobody;

  const Clock::time_point begin = Clock::now();
  std::vector<Errors> stages;
  const auto record = [&](const CalibrationState& state) {
    stages.push_back(ErrorsOf(state.lidars, truth, !test.with_guess));
    stages.back().seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  };
  std::vector<DriveOdometry> odometry;
  odometry.push_back(RunDriveOdometry(rig, dataset.drives[0], never, [](double) {}));
  Initialization start = Initialize(rig, dataset, odometry, never);
  if (start.state.drives.empty()) {
    throw std::runtime_error(std::string(test.name) +
                             ": no start: " + (start.problems.empty() ? "" : start.problems.front()));
  }
  record(start.state);
  const AdjustmentContext context{rig, dataset, nobody, {never}};
  Adjustment adjustment = StartAdjustment(rig, dataset, std::move(start));
  if (rig.lidars.size() > 1) adjustment = AdjustEachLidar(std::move(adjustment), context);
  record(adjustment.state);
  adjustment = AdjustJointly(std::move(adjustment), context, {});
  record(adjustment.state);
  return stages;
}

double Median(const std::vector<Errors>& runs, double Errors::*member) {
  std::vector<double> values;
  for (const Errors& run : runs) values.push_back(run.*member);
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void RunCase(const Case& test, double duration, int seeds) {
  std::vector<std::vector<Errors>> runs(3);
  for (int seed = 1; seed <= seeds; ++seed) {
    const std::vector<Errors> stages = RunOnce(test, duration, static_cast<std::uint64_t>(seed));
    for (std::size_t s = 0; s < 3; ++s) runs[s].push_back(stages[s]);
  }
  const char* names[3] = {"hand-eye", "single LiDAR", "joint"};
  for (std::size_t s = 0; s < 3; ++s) {
    std::printf("| %-28s | %-12s | %8.4f | %7.2f | %7.4f | %8.4f | %7.2f | %5.1f |\n", test.name, names[s],
                Median(runs[s], &Errors::imu_rotation), Median(runs[s], &Errors::imu_translation),
                Median(runs[s], &Errors::time_offset), Median(runs[s], &Errors::pair_rotation),
                Median(runs[s], &Errors::pair_translation), Median(runs[s], &Errors::seconds));
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  const double duration = argc > 1 ? std::atof(argv[1]) : 30.0;
  const int seeds = argc > 2 ? std::max(1, std::atoi(argv[2])) : 1;
  using mlic::sim::Scenario;
  const std::vector<mlic::Case> cases{
      {"hand-held, 32 rings", "handheld.yaml", Scenario::kHandheld, false},
      {"hand-held, two rosettes", "dual_rosette.yaml", Scenario::kHandheld, false},
      {"car, figure eight, 4 LiDARs", "paper_rig_lidars.yaml", Scenario::kFigureEight, true}};
  std::printf(
      "| drive | stage | LiDAR-IMU, deg | mm | ms | LiDAR-LiDAR, deg | mm | s |\n"
      "|---|---|---|---|---|---|---|---|\n");
  try {
    for (const mlic::Case& test : cases) mlic::RunCase(test, duration, seeds);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "calibration_benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}
