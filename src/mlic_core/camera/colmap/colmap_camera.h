#pragma once

#include <vector>

#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// COLMAP's own models that we use, with its numbers (src/base/camera_models.h; the same in all versions).
enum class ColmapModelId { kOpenCv = 4, kOpenCvFisheye = 5, kFullOpenCv = 6 };

// The COLMAP model that stands for one of ours while COLMAP works: OPENCV for plumb_bob (k3 is 0 there),
// FULL_OPENCV for rational_polynomial, OPENCV_FISHEYE for equidistant and double_sphere.
ColmapModelId ColmapModelFor(CameraModel model);

// Intrinsics in the words of that model: ours with k3 0, or fitted to ours where the model is another.
CameraIntrinsics ToColmapModel(const CameraIntrinsics& intrinsics);

// Its parameters in COLMAP's order and convention (a pixel's centre at 0.5), and back.
std::vector<double> ToColmapParameters(const CameraIntrinsics& intrinsics);
CameraIntrinsics FromColmapParameters(ColmapModelId model, int width, int height,
                                      const std::vector<double>& parameters);

// Fits a model to given intrinsics of another by least squares of the projections of the bearings that a grid
// of pixels sees, as far as largest_angle (rad) from the axis.
CameraIntrinsics FitCameraModel(const CameraIntrinsics& given, CameraModel model, double largest_angle);

}  // namespace mlic
