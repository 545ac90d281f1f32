#include "mlic_core/camera/colmap/colmap_camera.h"

// The part of colmap_database.h that is about camera models.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

// from: structural, a grid that is dense against distortion.
constexpr int kGrid = 24;                           // along each side of the image
constexpr int kFitIterations = 30;                  // from: guard, ends by convergence
constexpr double kWidestFit = 80.0 * M_PI / 180.0;  // from: derivation, as kWidestAngle of colmap.cc

struct PixelRay {
  Eigen::Vector3d bearing;
  Eigen::Vector2d pixel;
};

std::vector<PixelRay> GridRays(const CameraIntrinsics& camera, double largest_angle) {
  std::vector<PixelRay> rays;
  for (int row = 0; row <= kGrid; ++row) {
    for (int column = 0; column <= kGrid; ++column) {
      PixelRay ray;
      ray.pixel = {(camera.width - 1.0) * column / kGrid, (camera.height - 1.0) * row / kGrid};
      if (Unproject(camera, ray.pixel, &ray.bearing) && ray.bearing.z() > std::cos(largest_angle)) {
        rays.push_back(ray);
      }
    }
  }
  return rays;
}

// Normal equations of the pixel differences; the cost, where a ray without projection costs much.
double Linearize(const CameraIntrinsics& camera, const std::vector<PixelRay>& rays, Eigen::MatrixXd* H,
                 Eigen::VectorXd* g) {
  constexpr double kLost = 1e6;  // from: guard, more than any pixel error
  const int count = ParameterCount(camera.model);
  H->setZero(count, count);
  g->setZero(count);
  double cost = 0.0;
  for (const PixelRay& ray : rays) {
    Eigen::Vector2d pixel;
    CameraParameterJacobian J;
    if (!Project(camera, ray.bearing, &pixel, nullptr, &J)) {
      cost += kLost;
      continue;
    }
    const Eigen::Vector2d r = pixel - ray.pixel;
    cost += r.squaredNorm();
    *H += J.transpose() * J;
    *g += J.transpose() * r;
  }
  return cost;
}

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
  const std::vector<PixelRay> rays = GridRays(given, largest_angle);
  CameraIntrinsics camera = StartOf(given, model);
  Eigen::MatrixXd H, H_new;
  Eigen::VectorXd g, g_new;
  double cost = Linearize(camera, rays, &H, &g);
  double damping = 1e-4;
  for (int iteration = 0; iteration < kFitIterations; ++iteration) {
    Eigen::MatrixXd damped = H;
    damped.diagonal() += (damping * H.diagonal().array() + 1e-12).matrix();
    const Eigen::VectorXd step = damped.ldlt().solve(-g);
    CameraIntrinsics moved = camera;
    for (int k = 0; k < step.size(); ++k) moved.parameters[static_cast<std::size_t>(k)] += step[k];
    const double new_cost = Linearize(moved, rays, &H_new, &g_new);
    if (new_cost < cost) {
      camera = moved;
      cost = new_cost;
      H = H_new;
      g = g_new;
      damping *= 0.1;
    } else {
      damping *= 10.0;
    }
  }
  return camera;
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
