#include "mlic_core/sensors/lens_reach.h"

#include <Eigen/Core>
#include <algorithm>

#include "mlic_core/sensors/camera_model.h"

namespace mlic {
namespace {

// The share of the way to this corner, which is `half` off the middle.
double ReachTowards(const CameraIntrinsics& lens, const Eigen::Vector2d& middle,
                    const Eigen::Vector2d& half) {
  constexpr int kSteps = 64;       // from: structural
  constexpr double kMargin = 1.1;  // of the tangent; from: guard, a pole stretches the last tenth before it
  for (int i = 1; i <= kSteps; ++i) {
    Eigen::Vector3d bearing;
    const Eigen::Vector2d pixel = middle + half * i / kSteps;
    // Towards a pole pixels crowd to one direction, and none has a sight beyond.
    const auto farther = [&] {
      const Eigen::Vector3d ray(kMargin * bearing.x(), kMargin * bearing.y(), bearing.z());
      Eigen::Vector2d beyond;
      return Project(lens, ray, &beyond);
    };
    if (!Unproject(lens, pixel, &bearing) || !farther()) return static_cast<double>(i - 1) / kSteps;
  }
  return 1.0;
}

}  // namespace

double ReachOfLens(const CameraIntrinsics& lens) {
  const Eigen::Vector2d middle(0.5 * (lens.width - 1.0), 0.5 * (lens.height - 1.0));
  double reach = 1.0;
  for (const double u : {-1.0, 1.0}) {
    for (const double v : {-1.0, 1.0}) {
      reach = std::min(reach, ReachTowards(lens, middle, middle.cwiseProduct(Eigen::Vector2d(u, v))));
    }
  }
  return reach;
}

}  // namespace mlic
