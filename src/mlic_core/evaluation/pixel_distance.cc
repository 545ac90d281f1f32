#include "mlic_core/evaluation/pixel_distance.h"

#include <Eigen/LU>

#include "mlic_core/sensors/camera_model.h"

namespace mlic {

bool PixelDistance(const CameraIntrinsics& intrinsics, const Eigen::Vector3d& bearing,
                   const Eigen::Vector3d& normal, double* distance) {
  Eigen::Vector2d pixel;
  CameraPointJacobian J;
  if (!Project(intrinsics, bearing, &pixel, &J)) return false;
  // The shortest change of the bearing for a change of the pixel is J^T (J J^T)^-1.
  const Eigen::Vector2d gradient = (J * J.transpose()).inverse() * (J * normal);
  const double slope = gradient.norm();
  if (!(slope > 1e-12)) return false;
  *distance = normal.dot(bearing) / slope;
  return true;
}

}  // namespace mlic
