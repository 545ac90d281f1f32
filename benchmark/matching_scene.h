#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mlic_core/crossmodal/camera_to_map.h"
#include "mlic_sim/simulation.h"

namespace mlic {

// What the map-matching stage works on, with everything but the camera true: the LiDARs' map of one stretch
// of a simulated drive, and photos of one camera in it.
struct MatchingSceneOptions {
  std::string sensors;  // of config/simulation, without .yaml; or a path
  std::string camera;   // its name
  sim::Scenario scenario = sim::Scenario::kHandheld;
  double duration = 12.0;  // s, as association/map_matches.h's windows
  std::size_t photos = 8;
  std::uint64_t seed = 1;
  std::size_t map_points = 3000000;
};

class MatchingScene {
 public:
  explicit MatchingScene(const MatchingSceneOptions& options);

  const IntensityMap& map() const { return map_; }
  const sim::SimulatedCamera& camera() const { return camera_; }
  const std::vector<PhotoOnMap>& photos() const { return photos_; }
  const RigidTransform& truth() const { return camera_.calibration.T_imu_sensor; }

 private:
  sim::SimulatedCamera camera_;
  std::unique_ptr<sim::Trajectory> trajectory_;
  IntensityMap map_;
  std::vector<PhotoOnMap> photos_;
};

// run(argc, argv) with errors printed as "name: what"; the exit status.
int RunBenchmark(const char* name, void (*run)(int, char**), int argc, char** argv);

}  // namespace mlic
