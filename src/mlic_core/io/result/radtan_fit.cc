#include "mlic_core/io/result/radtan_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

namespace mlic {
namespace {

constexpr int kColumns = 40, kRows = 30;  // from: structural, a grid that is dense against distortion
constexpr std::size_t kFewestRays = 100;  // fewer say nothing about an image; from: guard
constexpr int kIterations = 20;           // from: guard, ends by convergence
constexpr int kFree = 8;                  // fx fy cx cy k1 k2 p1 p2; from: structural

struct Ray {
  Eigen::Vector3d bearing;
  Eigen::Vector2d pixel;
};

std::vector<Ray> RaysOf(const CameraIntrinsics& camera) {
  std::vector<Ray> rays;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      Ray ray;
      ray.pixel = {(camera.width - 1.0) * column / (kColumns - 1), (camera.height - 1.0) * row / (kRows - 1)};
      if (Unproject(camera, ray.pixel, &ray.bearing)) rays.push_back(ray);
    }
  }
  return rays;
}

}  // namespace

RadtanFit FitRadtan(const CameraIntrinsics& camera) {
  RadtanFit fit;
  fit.intrinsics = camera;
  fit.intrinsics.model = CameraModel::kPlumbBob;
  fit.intrinsics.parameters.assign(camera.parameters.begin(), camera.parameters.begin() + 4);
  fit.intrinsics.parameters.resize(ParameterCount(CameraModel::kPlumbBob), 0.0);
  const std::vector<Ray> rays = RaysOf(camera);
  Eigen::Vector2d pixel;
  CameraParameterJacobian J;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix<double, kFree, kFree> information = Eigen::Matrix<double, kFree, kFree>::Zero();
    Eigen::Matrix<double, kFree, 1> gradient = Eigen::Matrix<double, kFree, 1>::Zero();
    for (const Ray& ray : rays) {
      if (!Project(fit.intrinsics, ray.bearing, &pixel, nullptr, &J)) continue;
      const Eigen::Matrix<double, 2, kFree> J_free = J.leftCols<kFree>();
      information += J_free.transpose() * J_free;
      gradient += J_free.transpose() * (pixel - ray.pixel);
    }
    const Eigen::Matrix<double, kFree, 1> step = information.ldlt().solve(gradient);
    if (!step.allFinite()) break;
    for (int i = 0; i < kFree; ++i) fit.intrinsics.parameters[i] -= step[i];
  }
  if (rays.size() < kFewestRays) fit.mean = fit.largest = camera.width;
  for (const Ray& ray : rays) {
    // A ray that the fit cannot see is as wrong as the image is wide.
    const bool seen = Project(fit.intrinsics, ray.bearing, &pixel);
    const double distance = seen ? (pixel - ray.pixel).norm() : camera.width;
    fit.mean += distance / static_cast<double>(rays.size());
    fit.largest = std::max(fit.largest, distance);
  }
  return fit;
}

}  // namespace mlic
