// Time and accuracy of the LiDAR odometry on simulated drives, one thread:
//   odometry_benchmark [SECONDS]        (from the repository root; the default is 15 s of each drive)
// Prints a table: time for each scan (filter included), root mean square error of the motion over one second,
// error of the motion over 10 m in percent of the way, root mean square distance from the true path after
// alignment.

#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/lidar/odometry.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/simulation.h"

namespace mlic {
namespace {

using Clock = std::chrono::steady_clock;

struct Case {
  const char* name;
  const char* sensors;
  sim::Scenario scenario;
  std::size_t lidar;
};

struct Figures {
  double second_translation = 0.0;  // m
  double second_rotation = 0.0;     // degrees
  double drift_percent = 0.0;
  double path_error = 0.0;  // m
};

Figures Compare(const std::vector<TimedPose>& poses, const std::vector<RigidTransform>& truth) {
  const auto error = [&](std::size_t i, std::size_t k) {
    return (truth[i].Inverse() * truth[k]).Inverse() * (poses[i].pose.Inverse() * poses[k].pose);
  };
  Figures figures;
  const std::size_t second = 10;
  for (std::size_t i = 0; i + second < poses.size(); ++i) {
    const RigidTransform e = error(i, i + second);
    figures.second_translation += e.translation.squaredNorm() / (poses.size() - second);
    figures.second_rotation += Log(e.rotation).squaredNorm() / (poses.size() - second);
  }
  figures.second_translation = std::sqrt(figures.second_translation);
  figures.second_rotation = std::sqrt(figures.second_rotation) * 180.0 / M_PI;

  std::vector<double> way(1, 0.0);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    way.push_back(way.back() + (truth[i].translation - truth[i - 1].translation).norm());
  }
  std::size_t pieces = 0;
  for (std::size_t i = 0, k = 0; i < poses.size(); ++i) {
    while (k < poses.size() && way[k] - way[i] < 10.0) ++k;
    if (k == poses.size()) break;
    figures.drift_percent += 100.0 * error(i, k).translation.norm() / (way[k] - way[i]);
    ++pieces;
  }
  if (pieces > 0) figures.drift_percent /= static_cast<double>(pieces);

  Eigen::Matrix3Xd estimated(3, poses.size()), exact(3, poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    estimated.col(i) = poses[i].pose.translation;
    exact.col(i) = truth[i].translation;
  }
  const Eigen::Matrix4d T = Eigen::umeyama(estimated, exact, false);
  const Eigen::Matrix3Xd aligned =
      (T.topLeftCorner<3, 3>() * estimated).colwise() + T.topRightCorner<3, 1>().eval();
  figures.path_error = std::sqrt((aligned - exact).colwise().squaredNorm().mean());
  return figures;
}

void RunCase(const Case& test, double duration) {
  sim::SensorSet sensors = sim::LoadSensorSet(std::string("config/simulation/") + test.sensors);
  sensors.lidars = {sensors.lidars.at(test.lidar)};
  sim::SimulationOptions options;
  options.scenario = test.scenario;
  options.duration = duration;
  LidarRecording recording = sim::SimulateDrive(sensors, options).lidars[0];

  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const Clock::time_point begin = Clock::now();
  for (LidarScan& scan : recording.scans) FilterScan(scan);
  const std::vector<TimedPose> poses = RunOdometry(recording, {}, kAllScans, CancellationToken(), nullptr);
  const double milliseconds = 1e3 * std::chrono::duration<double>(Clock::now() - begin).count();

  const auto trajectory = sim::MakeTrajectory(sensors, options);
  const SensorCalibration& calibration = sensors.lidars[0].calibration;
  std::vector<RigidTransform> truth;
  for (const TimedPose& pose : poses) {
    truth.push_back(trajectory->PoseAt(pose.time + calibration.time_offset) * calibration.T_imu_sensor);
  }
  const Figures figures = Compare(poses, truth);
  std::printf("| %-28s | %6.2f | %7.2f | %7.4f | %6.3f | %6.2f |\n", test.name, milliseconds / poses.size(),
              1e3 * figures.second_translation, figures.second_rotation, figures.drift_percent,
              1e2 * figures.path_error);
  std::fflush(stdout);
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  const double duration = argc > 1 ? std::atof(argv[1]) : 15.0;
  using mlic::sim::Scenario;
  const std::vector<mlic::Case> cases{
      {"hand-held, 32 rings", "handheld.yaml", Scenario::kHandheld, 0},
      {"hand-held, rosette 70 deg", "dual_rosette.yaml", Scenario::kHandheld, 0},
      {"car, spinning", "spinning_car.yaml", Scenario::kFigureEight, 0},
      {"car, 120 x 25 deg, front", "paper_rig_lidars.yaml", Scenario::kFigureEight, 0},
      {"car, 120 x 25 deg, back", "paper_rig_lidars.yaml", Scenario::kFigureEight, 1},
      {"car, 120 x 25 deg, left", "paper_rig_lidars.yaml", Scenario::kFigureEight, 2},
      {"car, 120 x 25 deg, right", "paper_rig_lidars.yaml", Scenario::kFigureEight, 3}};
  std::printf("| drive | ms/scan | 1 s, mm | 1 s, deg | drift, %% | path, cm |\n|---|---|---|---|---|---|\n");
  try {
    for (const mlic::Case& test : cases) mlic::RunCase(test, duration);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "odometry_benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}
