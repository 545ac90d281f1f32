// Time of making and drawing the intensity map of the paper's rig:
//   renderer_benchmark [SECONDS]        (from the repository root; the default is 25 s of drive: 10 million
//   points)
// Prints the time of each step of the map and, for each camera, the processor time of a view and the views in
// a second of all cores. Processor time: other programs on the machine do not count.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>

#include "mlic_core/crossmodal/renderer.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/simulation.h"
#include "support/true_spline.h"

namespace mlic {
namespace {

class Stopwatch {
 public:
  Stopwatch() : wall_(std::chrono::steady_clock::now()), processor_(std::clock()) {}
  double Wall() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count();
  }
  double Processor() const { return static_cast<double>(std::clock() - processor_) / CLOCKS_PER_SEC; }

 private:
  std::chrono::steady_clock::time_point wall_;
  std::clock_t processor_;
};

void Print(const char* what, const Stopwatch& watch) {
  std::printf("%-24s %6.2f s, processor %6.2f s\n", what, watch.Wall(), watch.Processor());
}

void Run(double duration) {
  const sim::SensorSet set = sim::LoadSensorSet("config/simulation/paper_rig.yaml");
  sim::SimulationOptions simulation;
  simulation.duration = duration;
  const Drive drive = sim::SimulateDrive(set, simulation, [](LidarScan& scan) { FilterScan(scan); });
  const auto truth = sim::MakeTrajectory(set, simulation);
  const SplitSpline trajectory = TrueSpline(*truth, duration);

  const Stopwatch collect;
  const std::vector<MapReturn> returns =
      CollectReturns(drive, trajectory, sim::TrueCalibrations(set), 10000000);
  Print("returns into the map", collect);
  const Stopwatch build;
  const IntensityMap map = BuildIntensityMap(returns);
  Print("map", build);
  std::printf("%zu points in %zu cells\n", map.points.size(), map.cells.size());

  for (const sim::SimulatedCamera& camera : set.cameras) {
    CameraIntrinsics intrinsics = camera.intrinsics;
    std::vector<ViewPose> poses;
    for (int k = 0; k < 16; ++k) {
      const double time = 0.5 + (duration - 1.0) * k / 16.0;
      poses.push_back(PoseOnTrajectory(trajectory, camera.calibration, time, 0.0, intrinsics.height));
    }
    const Stopwatch watch;
    const std::vector<RenderedView> views = RenderViews(map, intrinsics, poses, {});
    const double count = static_cast<double>(views.size());
    std::printf("%-14s %d x %d: %5.1f ms of one core a view, %5.1f views/s\n", camera.name.c_str(),
                intrinsics.width, intrinsics.height, 1e3 * watch.Processor() / count, count / watch.Wall());
  }
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  try {
    mlic::Run(argc > 1 ? std::atof(argv[1]) : 25.0);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "renderer_benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}
