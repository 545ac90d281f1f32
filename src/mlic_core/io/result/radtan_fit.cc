#include "mlic_core/io/result/radtan_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/camera/model_fit.h"
#include "mlic_core/io/rig/rig_parsing.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

constexpr int kColumns = 40, kRows = 30;  // from: structural, a grid that is dense against distortion
constexpr std::size_t kFewestRays = 100;  // fewer say nothing about an image; from: guard
constexpr int kFree = 8;                  // fx fy cx cy k1 k2 p1 p2; from: structural

// from: definition, docs/outputs.md.
constexpr double kLargestMeanError = 0.2;  // px, of a camera that is written as a model with fewer terms

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

std::optional<RadtanCamera> AsRadtan(const CameraIntrinsics& camera) {
  if (camera.model != CameraModel::kPlumbBob && camera.model != CameraModel::kRationalPolynomial) {
    return std::nullopt;
  }
  const auto first_terms = [](const std::vector<double>& p, const std::string& remark) {
    return RadtanCamera{{p.begin(), p.begin() + 4}, {p.begin() + 4, p.begin() + 8}, remark};
  };
  const std::vector<double>& p = camera.parameters;
  if (std::all_of(p.begin() + 8, p.end(), [](double value) { return value == 0.0; }))
    return first_terms(p, "");
  const RadtanFit fit = FitRadtan(camera);
  if (!(fit.mean < kLargestMeanError)) return std::nullopt;
  return first_terms(fit.intrinsics.parameters,
                     "fitted to the camera's " + CameraModelNames()[static_cast<std::size_t>(camera.model)] +
                         ", of which radtan lacks terms: pixels off by " + FixedNumber(fit.mean, 3) +
                         " in the mean, " + FixedNumber(fit.largest, 3) + " at most");
}

}  // namespace mlic
