#include "matching_scene.h"

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_sim/image_stage.h"
#include "support/true_spline.h"

namespace mlic {
namespace {

std::size_t IndexOf(const sim::SensorSet& set, const std::string& camera) {
  for (std::size_t c = 0; c < set.cameras.size(); ++c) {
    if (set.cameras[c].name == camera) return c;
  }
  throw InputError("no camera '" + camera + "' in the sensors file");
}

std::string PathOf(const std::string& sensors) {
  return sensors.find('/') == std::string::npos ? "config/simulation/" + sensors + ".yaml" : sensors;
}

}  // namespace

MatchingScene::MatchingScene(const MatchingSceneOptions& options) {
  sim::SensorSet set = sim::LoadSensorSet(PathOf(options.sensors));
  camera_ = set.cameras[IndexOf(set, options.camera)];
  set.cameras = {camera_};
  sim::SimulationOptions simulation;
  simulation.scenario = options.scenario;
  simulation.duration = options.duration;
  simulation.seed = options.seed;
  const Drive drive = sim::SimulateDrive(set, simulation, [](LidarScan& scan) { FilterScan(scan); });
  trajectory_ = sim::MakeTrajectory(set, simulation);
  map_ = BuildIntensityMap(CollectReturns(drive, TrueSpline(*trajectory_, options.duration),
                                          sim::TrueCalibrations(set), options.map_points));
  const std::vector<double> times = sim::ImageTimes(camera_, options.duration);
  photos_.resize(options.photos);
  ParallelFor(options.photos, [&](std::size_t k) {
    const std::size_t index = (2 * k + 1) * times.size() / (2 * options.photos);
    const double time = times[index];
    const double row_time = camera_.readout / camera_.intrinsics.height;
    photos_[k] = {ToGray(drive.cameras[0].images->Load(index)),
                  {},
                  [this, time, row_time](double row) { return trajectory_->PoseAt(time + row * row_time); },
                  camera_.rolling_shutter};
  });
}

int RunBenchmark(const char* name, void (*run)(int, char**), int argc, char** argv) {
  try {
    run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
  return 0;
}

}  // namespace mlic
