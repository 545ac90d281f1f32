#pragma once

#include <vector>

#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// A direction in the camera's frame (unit) and the pixel that shows it.
struct PixelRay {
  Eigen::Vector3d bearing;
  Eigen::Vector2d pixel;
};

// Rays of `columns` x `rows` pixels spread over the whole image, corners included; those less than
// largest_angle (rad) from the optical axis.
std::vector<PixelRay> GridRays(const CameraIntrinsics& camera, int columns, int rows, double largest_angle);

// The intrinsics near `start`, of its model, with the least squares of the pixels' distances; only the first
// `free` parameters move. A ray that the model cannot project counts as 1000 px, so that a step that loses
// rays is not taken.
CameraIntrinsics FitToRays(const CameraIntrinsics& start, const std::vector<PixelRay>& rays, int free);

}  // namespace mlic
