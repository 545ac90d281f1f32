// How far off a camera may be for the map-matching stage to find it, all else true:
//   basin_benchmark SENSORS CAMERA SCENARIO [PHOTOS] [TRIALS] > TABLE.csv       (from the repository root)
//   basin_benchmark handheld_stereo cam_left handheld
//   basin_benchmark paper_rig cam_front_190 figure_eight
// Starts are turned by each of some angles about random axes and moved by 0 or 5 cm in random directions; the
// stage is told these sizes as its uncertainty. One line for each trial: the start's errors and the result's.
// basin_plot.py makes the figure. The same arguments give the same lines.

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "matching_scene.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kAngles[] = {0.25, 0.5, 1.0, 2.0};  // deg
constexpr double kShifts[] = {0.0, 0.05};            // m
constexpr double kLeastShift = 0.005;                // m: uncertainty of a start that is not moved

Eigen::Vector3d Direction(Random* random) {
  return Eigen::Vector3d(random->Normal(), random->Normal(), random->Normal()).normalized();
}

void Try(const MatchingScene& scene, const char* camera, double angle, double shift, std::uint64_t seed) {
  Random random(seed);
  RigidTransform guess = scene.truth();
  guess.rotation = guess.rotation * ExpQuaternion(angle * kDegree * Direction(&random));
  guess.translation += shift * Direction(&random);
  const auto result = AlignCameraToMap(scene.map(), scene.camera().intrinsics, scene.photos(), guess,
                                       UncertaintyOf(angle * kDegree, std::max(shift, kLeastShift)), {});
  double rotation = angle, translation = shift, share = 0.0;
  int rounds = 0;
  if (result) {
    rotation = AngleBetween(result->T_body_camera.rotation, scene.truth().rotation) / kDegree;
    translation = (result->T_body_camera.translation - scene.truth().translation).norm();
    share = result->inlier_share, rounds = result->rounds;
  }
  std::printf("%s,%.2f,%.3f,%llu,%d,%.5f,%.6f,%.3f,%d\n", camera, angle, shift,
              static_cast<unsigned long long>(seed), result ? 1 : 0, rotation, translation, share, rounds);
  std::fflush(stdout);
}

void Run(int argc, char** argv) {
  if (argc < 4) throw std::runtime_error("usage: basin_benchmark SENSORS CAMERA SCENARIO [PHOTOS] [TRIALS]");
  MatchingSceneOptions options;
  options.sensors = argv[1], options.camera = argv[2];
  options.scenario = sim::ScenarioFromName(argv[3]);
  if (argc > 4) options.photos = static_cast<std::size_t>(std::atoi(argv[4]));
  const int trials = argc > 5 ? std::atoi(argv[5]) : 20;  // for each angle and shift
  const MatchingScene scene(options);
  std::printf("camera,start_deg,start_m,seed,found,rotation_deg,translation_m,inlier_share,rounds\n");
  for (const double angle : kAngles) {
    for (const double shift : kShifts) {
      for (int k = 0; k < trials; ++k) Try(scene, argv[2], angle, shift, static_cast<std::uint64_t>(k + 1));
    }
  }
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) { return mlic::RunBenchmark("basin_benchmark", mlic::Run, argc, argv); }
