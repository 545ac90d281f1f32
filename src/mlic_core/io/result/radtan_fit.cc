#include "mlic_core/io/result/radtan_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/camera/model_fit.h"

namespace mlic {
namespace {

constexpr int kColumns = 40, kRows = 30;  // from: structural, a grid that is dense against distortion
constexpr std::size_t kFewestRays = 100;  // fewer say nothing about an image; from: guard
constexpr int kFree = 8;                  // fx fy cx cy k1 k2 p1 p2; from: structural

}  // namespace

RadtanFit FitRadtan(const CameraIntrinsics& camera) {
  RadtanFit fit;
  fit.intrinsics = camera;
  fit.intrinsics.model = CameraModel::kPlumbBob;
  fit.intrinsics.parameters.assign(camera.parameters.begin(), camera.parameters.begin() + 4);
  fit.intrinsics.parameters.resize(ParameterCount(CameraModel::kPlumbBob), 0.0);
  const std::vector<PixelRay> rays = GridRays(camera, kColumns, kRows, M_PI);
  fit.intrinsics = FitToRays(fit.intrinsics, rays, kFree);
  if (rays.size() < kFewestRays) fit.mean = fit.largest = camera.width;
  for (const PixelRay& ray : rays) {
    Eigen::Vector2d pixel;
    // A ray that the fit cannot see is as wrong as the image is wide.
    const bool seen = Project(fit.intrinsics, ray.bearing, &pixel);
    const double distance = seen ? (pixel - ray.pixel).norm() : camera.width;
    fit.mean += distance / static_cast<double>(rays.size());
    fit.largest = std::max(fit.largest, distance);
  }
  return fit;
}

}  // namespace mlic
