#include "mlic_core/io/result/camera_info.h"

#include "mlic_core/io/rig/rig_parsing.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

std::string Matrix(const std::string& name, int rows, int columns, const std::vector<double>& values) {
  std::string data;
  for (const double value : values) data += (data.empty() ? "" : ", ") + ShortNumber(value, 12);
  return name + ":\n  rows: " + std::to_string(rows) + "\n  cols: " + std::to_string(columns) +
         "\n  data: [" + data + "]\n";
}

}  // namespace

std::string CameraInfoText(const SensorResult& camera) {
  if (!camera.intrinsics || camera.intrinsics->model == CameraModel::kDoubleSphere) return "";
  const CameraIntrinsics& intrinsics = *camera.intrinsics;
  const std::vector<double>& p = intrinsics.parameters;
  // CameraInfo lists rational_polynomial as k1 k2 p1 p2 k3 k4 k5 k6, as we do.
  const std::vector<double> distortion(p.begin() + 4, p.end());
  return "# Stamps: t_imu = t_camera + (" + FixedNumber(camera.calibration.time_offset, 9) +
         " s). The file has no place for that, nor for the pose.\nimage_width: " +
         std::to_string(intrinsics.width) + "\nimage_height: " + std::to_string(intrinsics.height) +
         "\ncamera_name: " + camera.name + "\n" +
         Matrix("camera_matrix", 3, 3, {p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1}) +
         "distortion_model: " + CameraModelNames()[static_cast<std::size_t>(intrinsics.model)] + "\n" +
         Matrix("distortion_coefficients", 1, static_cast<int>(distortion.size()), distortion) +
         Matrix("rectification_matrix", 3, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         Matrix("projection_matrix", 3, 4, {p[0], 0, p[2], 0, 0, p[1], p[3], 0, 0, 0, 1, 0});
}

void WriteCameraInfos(const std::filesystem::path& directory, const CalibrationResult& result) {
  for (const SensorResult& sensor : result.sensors) {
    const std::string text = CameraInfoText(sensor);
    if (!text.empty()) WriteFileAtomically(directory / (sensor.name + ".yaml"), text);
  }
}

}  // namespace mlic
