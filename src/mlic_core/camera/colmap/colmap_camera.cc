#include "mlic_core/camera/colmap/colmap_camera.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/camera/model_fit.h"
#include "mlic_core/common/error.h"

namespace mlic {
namespace {

// Pixels along each side of the image; from: structural, a grid that is dense against distortion.
constexpr int kGrid = 25;
constexpr double kWidestFit = 80.0 * M_PI / 180.0;  // from: derivation, as kWidestAngle of colmap.cc

// A start whose focal length fits near the axis.
CameraIntrinsics StartOf(const CameraIntrinsics& given, CameraModel model) {
  CameraIntrinsics start{model, given.width, given.height, {}};
  start.parameters.assign(static_cast<std::size_t>(ParameterCount(model)), 0.0);
  std::copy_n(given.parameters.begin(), 4, start.parameters.begin());
  // The focal length along the axis: what a bearing just beside it says.
  Eigen::Vector2d centre, beside;
  if (Project(given, Eigen::Vector3d(0.0, 0.0, 1.0), &centre) &&
      Project(given, Eigen::Vector3d(1e-3, 1e-3, 1.0), &beside)) {
    start.parameters[0] = 1e3 * (beside.x() - centre.x());
    start.parameters[1] = 1e3 * (beside.y() - centre.y());
  }
  if (model == CameraModel::kDoubleSphere) {
    start.parameters[4] = 0.0;
    start.parameters[5] = 0.6;  // between a pinhole and half a sphere
  }
  return start;
}

}  // namespace

CameraIntrinsics FitCameraModel(const CameraIntrinsics& given, CameraModel model, double largest_angle) {
  return FitToRays(StartOf(given, model), GridRays(given, kGrid, kGrid, largest_angle),
                   ParameterCount(model));
}

ColmapModelId ColmapModelFor(CameraModel model) {
  switch (model) {
    case CameraModel::kPlumbBob:
      return ColmapModelId::kOpenCv;
    case CameraModel::kRationalPolynomial:
      return ColmapModelId::kFullOpenCv;
    case CameraModel::kEquidistant:
    case CameraModel::kDoubleSphere:
      return ColmapModelId::kOpenCvFisheye;
  }
  throw InternalError("a camera model without one of COLMAP's");
}

CameraIntrinsics ToColmapModel(const CameraIntrinsics& intrinsics) {
  if (intrinsics.model == CameraModel::kDoubleSphere) {
    return FitCameraModel(intrinsics, CameraModel::kEquidistant, kWidestFit);
  }
  CameraIntrinsics camera = intrinsics;
  if (camera.model == CameraModel::kPlumbBob) camera.parameters[8] = 0.0;
  return camera;
}

std::vector<double> ToColmapParameters(const CameraIntrinsics& intrinsics) {
  Check(intrinsics.model != CameraModel::kDoubleSphere, "COLMAP has no double_sphere");
  std::vector<double> parameters = intrinsics.parameters;
  parameters[2] += 0.5;
  parameters[3] += 0.5;
  if (intrinsics.model == CameraModel::kPlumbBob) parameters.pop_back();
  return parameters;
}

CameraIntrinsics FromColmapParameters(ColmapModelId model, int width, int height,
                                      const std::vector<double>& parameters) {
  CameraIntrinsics camera{CameraModel::kPlumbBob, width, height, parameters};
  if (model == ColmapModelId::kFullOpenCv) camera.model = CameraModel::kRationalPolynomial;
  if (model == ColmapModelId::kOpenCvFisheye) camera.model = CameraModel::kEquidistant;
  if (model == ColmapModelId::kOpenCv) camera.parameters.push_back(0.0);
  Check(static_cast<int>(camera.parameters.size()) == ParameterCount(camera.model),
        "COLMAP's camera has an unexpected number of parameters");
  camera.parameters[2] -= 0.5;
  camera.parameters[3] -= 0.5;
  return camera;
}

}  // namespace mlic
