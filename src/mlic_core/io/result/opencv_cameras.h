#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// The cameras as cv::FileStorage reads them (YAML): camera_matrix, distortion_coefficients in OpenCV's order
// (for cv::fisheye where the model is equidistant), T_imu_camera and time_offset; and for every two of them R
// and T as cv::stereoCalibrate gives them. Cameras of double_sphere, which OpenCV has not, are left out with
// a comment. Empty where no camera is left.
std::string OpenCvCamerasText(const CalibrationResult& result);

}  // namespace mlic
