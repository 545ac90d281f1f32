#include "mlic_core/camera/model_fit.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/solver/small_fit.h"

namespace mlic {
namespace {

using RowMajor2X = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int kMostIterations = 50;  // from: guard, ends by convergence
constexpr double kLost = 1000.0;     // px, more than any pixel error; from: guard

}  // namespace

std::vector<PixelRay> GridRays(const CameraIntrinsics& camera, int columns, int rows, double largest_angle) {
  std::vector<PixelRay> rays;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      PixelRay ray;
      ray.pixel = {(camera.width - 1.0) * column / (columns - 1), (camera.height - 1.0) * row / (rows - 1)};
      if (Unproject(camera, ray.pixel, &ray.bearing) && ray.bearing.z() > std::cos(largest_angle)) {
        rays.push_back(ray);
      }
    }
  }
  return rays;
}

CameraIntrinsics FitToRays(const CameraIntrinsics& start, const std::vector<PixelRay>& rays, int free) {
  CameraIntrinsics camera = start;
  if (rays.empty()) return camera;
  CameraIntrinsics trial = start;
  const auto residual = [&](double const* const* blocks, double* r, double** jacobians) {
    std::copy_n(blocks[0], free, trial.parameters.begin());
    const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      Eigen::Map<Eigen::Vector2d> error(r + 2 * i);
      Eigen::Vector2d pixel;
      CameraParameterJacobian J;
      const bool seen = Project(trial, rays[i].bearing, &pixel, nullptr, wanted ? &J : nullptr);
      error = seen ? Eigen::Vector2d(pixel - rays[i].pixel) : Eigen::Vector2d(kLost, 0.0);
      if (!wanted) continue;
      Eigen::Map<RowMajor2X> to(jacobians[0] + 2 * i * free, 2, free);
      if (seen) {
        to = J.leftCols(free);
      } else {
        to.setZero();
      }
    }
    return true;
  };
  SmallFit fit;
  fit.Add(2 * static_cast<int>(rays.size()), residual, {{camera.parameters.data(), free}});
  fit.Solve(kMostIterations);
  return camera;
}

}  // namespace mlic
