#pragma once

#include <filesystem>
#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// Who reads the file: OpenVINS does so by OpenCV, which wants a line of its own first, and knows no ds.
enum class CamchainReader { kKalibr, kOpenVins };

// The cameras as Kalibr writes them (camchain-imucam.yaml): cam0, cam1, ... in the result's order, with
// T_cam_imu (points of the IMU into the camera), T_cn_cnm1 (points of the camera before into this one) and
// timeshift_cam_imu (t_imu = t_cam + shift, the sign of our time offset). Kalibr's models: pinhole with
// radtan (four terms) or equidistant, and ds. Cameras with more terms are written as the nearest radtan where
// that is good to 0.2 px in the mean, and a comment says how good; others get no number and are named in a
// comment. Empty where there is no camera with intrinsics.
std::string KalibrCamchainText(const CalibrationResult& result, CamchainReader reader);

// Writes it, unless it is empty.
void WriteKalibrCamchain(const std::filesystem::path& path, const CalibrationResult& result);

}  // namespace mlic
