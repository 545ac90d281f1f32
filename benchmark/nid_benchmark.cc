// Whether NID should be a residual: a camera found by minimising the NID of photos and map alone, beside the
// same by matches of structure, all else true:
//   nid_benchmark SENSORS CAMERA SCENARIO [PHOTOS] [SEEDS]       (from the repository root)
//   nid_benchmark handheld_stereo cam_left handheld
// One line for each seed (another drive): the errors of the start, of NID's minimum and of the matches.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>

#include "matching_scene.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr int kPixelStep = 3;  // every so many pixels of a rendering are samples

// Mean NID of the photos as a function of the camera's pose; samples come from renderings at one pose.
class MeanNid {
 public:
  MeanNid(const MatchingScene& scene, const RigidTransform& T_body_camera)
      : scene_(scene), samples_(scene.photos().size()) {
    const ViewRenderer renderer(scene.map(), scene.camera().intrinsics, {});
    ParallelFor(samples_.size(), [&](std::size_t i) {
      const PhotoOnMap& photo = scene.photos()[i];
      const ViewPose pose{[&](double row) { return photo.T_map_body(row) * T_body_camera; }, photo.rolling};
      const RenderedView view = renderer.Render(pose);
      for (int v = 0; v < view.depth.rows; v += kPixelStep) {
        for (int u = 0; u < view.depth.cols; u += kPixelStep) {
          IntensitySample sample;
          if (!view.IsSeen(u, v)) continue;
          SurfaceAt(view, scene.camera().intrinsics, pose, Eigen::Vector2d(u, v), &sample.point);
          sample.point = photo.T_map_body(v).Inverse() * sample.point;
          sample.intensity = view.intensity.at<float>(v, u);
          samples_[i].push_back(sample);
        }
      }
    });
  }

  double At(const RigidTransform& T_body_camera) const {
    std::vector<double> nids(samples_.size());
    ParallelFor(samples_.size(), [&](std::size_t i) {
      const PhotoOnMap& photo = scene_.photos()[i];
      nids[i] = ProjectedNid(samples_[i], photo.gray, photo.mask, scene_.camera().intrinsics,
                             T_body_camera.Inverse(), {});
    });
    double sum = 0.0;
    for (const double nid : nids) sum += nid / static_cast<double>(nids.size());
    return sum;
  }

 private:
  const MatchingScene& scene_;
  std::vector<std::vector<IntensitySample>> samples_;
};

RigidTransform Moved(const RigidTransform& pose, int axis, double step) {
  RigidTransform moved = pose;
  if (axis < 3) moved.rotation = pose.rotation * ExpQuaternion(step * Eigen::Vector3d::Unit(axis));
  if (axis >= 3) moved.translation[axis - 3] += step;
  return moved;
}

// Pattern search: one axis after the other, steps halved when none helps.
RigidTransform MinimizeNid(const MatchingScene& scene, RigidTransform pose) {
  constexpr double kLever = 5.0;  // m: a step of rotation over one of translation
  for (double step = 0.1 * kDegree; step > 0.002 * kDegree; step *= 0.5) {
    const MeanNid nid(scene, pose);
    double best = nid.At(pose);
    bool helped = true;
    for (int sweep = 0; helped && sweep < 10; ++sweep) {
      helped = false;
      for (int k = 0; k < 12; ++k) {
        const double size = (k % 2 == 0 ? 1.0 : -1.0) * step * (k / 2 < 3 ? 1.0 : kLever);
        const RigidTransform candidate = Moved(pose, k / 2, size);
        const double value = nid.At(candidate);
        if (value < best) pose = candidate, best = value, helped = true;
      }
    }
  }
  return pose;
}

std::array<double, 2> ErrorOf(const MatchingScene& scene, const RigidTransform& pose) {
  return {AngleBetween(pose.rotation, scene.truth().rotation) / kDegree,
          1e3 * (pose.translation - scene.truth().translation).norm()};
}

void Run(int argc, char** argv) {
  if (argc < 4) throw std::runtime_error("usage: nid_benchmark SENSORS CAMERA SCENARIO [PHOTOS] [SEEDS]");
  MatchingSceneOptions options;
  options.sensors = argv[1], options.camera = argv[2];
  options.scenario = sim::ScenarioFromName(argv[3]);
  if (argc > 4) options.photos = static_cast<std::size_t>(std::atoi(argv[4]));
  const int seeds = argc > 5 ? std::atoi(argv[5]) : 3;
  for (int seed = 1; seed <= seeds; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    const MatchingScene scene(options);
    Random random(options.seed);
    const Eigen::Vector3d axis(random.Normal(), random.Normal(), random.Normal());
    RigidTransform start = scene.truth();
    start.rotation = start.rotation * ExpQuaternion(0.1 * kDegree * axis.normalized());
    const auto by_nid = ErrorOf(scene, MinimizeNid(scene, start));
    const auto matched = AlignCameraToMap(scene.map(), scene.camera().intrinsics, scene.photos(), start,
                                          UncertaintyOf(0.1 * kDegree, 0.01), {});
    if (!matched) throw std::runtime_error("no match");
    const auto by_matches = ErrorOf(scene, matched->T_body_camera);
    std::printf("%s seed %d: start 0.1 deg; NID %.4f deg, %.2f mm; matches %.4f deg, %.2f mm\n", argv[2],
                seed, by_nid[0], by_nid[1], by_matches[0], by_matches[1]);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) { return mlic::RunBenchmark("nid_benchmark", mlic::Run, argc, argv); }
