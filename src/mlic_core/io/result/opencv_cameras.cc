#include "mlic_core/io/result/opencv_cameras.h"

#include <opencv2/core.hpp>
#include <vector>

#include "mlic_core/io/result/opencv_matrix.h"
#include "mlic_core/io/rig/rig_parsing.h"

namespace mlic {
namespace {

void WriteCamera(const SensorResult& camera, cv::FileStorage* file) {
  const CameraIntrinsics& intrinsics = *camera.intrinsics;
  const std::vector<double>& p = intrinsics.parameters;
  *file << camera.name << "{"
        << "image_width" << intrinsics.width << "image_height" << intrinsics.height << "distortion_model"
        << CameraModelNames()[static_cast<std::size_t>(intrinsics.model)] << "camera_matrix"
        << cv::Mat(cv::Matx33d(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1)) << "distortion_coefficients"
        << cv::Mat(std::vector<double>(p.begin() + 4, p.end()), true).reshape(1, 1) << "T_imu_camera"
        << HomogeneousMatrix(camera.calibration.T_imu_sensor) << "time_offset"
        << camera.calibration.time_offset;
  if (camera.rolling_shutter_readout) *file << "rolling_shutter_readout" << *camera.rolling_shutter_readout;
  *file << "}";
}

void WritePair(const SensorResult& first, const SensorResult& second, cv::FileStorage* file) {
  const cv::Mat T =
      HomogeneousMatrix(second.calibration.T_imu_sensor.Inverse() * first.calibration.T_imu_sensor);
  *file << first.name + "_to_" + second.name << "{"
        << "R" << T(cv::Rect(0, 0, 3, 3)).clone() << "T" << T(cv::Rect(3, 0, 1, 3)).clone() << "}";
}

}  // namespace

std::string OpenCvCamerasText(const CalibrationResult& result) {
  cv::FileStorage file(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file.writeComment(
      "T_imu_camera: p_imu = T * p_camera, metres. time_offset: t_imu = t_camera + time_offset, seconds.");
  file.writeComment("NAME1_to_NAME2: p_2 = R * p_1 + T. distortion_model equidistant: of cv::fisheye.");
  std::vector<const SensorResult*> cameras;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.intrinsics) continue;
    if (sensor.intrinsics->model == CameraModel::kDoubleSphere) {
      file.writeComment(sensor.name + " is omitted: OpenCV has no double_sphere");
    } else {
      cameras.push_back(&sensor);
      WriteCamera(sensor, &file);
    }
  }
  for (std::size_t a = 0; a < cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < cameras.size(); ++b) WritePair(*cameras[a], *cameras[b], &file);
  }
  const std::string text = file.releaseAndGetString();
  return cameras.empty() ? "" : text;
}

}  // namespace mlic
