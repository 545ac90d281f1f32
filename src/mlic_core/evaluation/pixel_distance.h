#pragma once

#include <Eigen/Core>

#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

// How far the pixel that sees a bearing is from the curve in the image where normal . bearing = 0 (the image
// of a plane through the camera's centre: an epipolar curve, a straight edge), px, to first order, with the
// sign of normal . bearing. For any camera model, also past 90 deg. False where the model does not hold.
bool PixelDistance(const CameraIntrinsics& intrinsics, const Eigen::Vector3d& bearing,
                   const Eigen::Vector3d& normal, double* distance);

}  // namespace mlic
