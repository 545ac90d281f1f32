#include "mlic_core/io/result/vins_fusion.h"

#include <opencv2/core.hpp>
#include <string>

#include "mlic_core/io/result/opencv_matrix.h"
#include "mlic_core/io/result/radtan_fit.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

void WriteNumbers(const std::string& key, const std::vector<std::string>& names,
                  const std::vector<double>& values, cv::FileStorage* file) {
  *file << key << "{";
  for (std::size_t i = 0; i < names.size(); ++i) *file << names[i] << values[i];
  *file << "}";
}

// Empty where VINS-Fusion has no model for it.
std::string CameraText(const SensorResult& camera) {
  const CameraIntrinsics& intrinsics = *camera.intrinsics;
  const bool fisheye = intrinsics.model == CameraModel::kEquidistant;
  const std::optional<RadtanCamera> radtan = AsRadtan(intrinsics);
  if (!fisheye && !radtan) return "";
  cv::FileStorage file(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  if (radtan && !radtan->remark.empty()) file.writeComment(radtan->remark);
  file << "model_type" << (fisheye ? "KANNALA_BRANDT" : "PINHOLE") << "camera_name" << camera.name
       << "image_width" << intrinsics.width << "image_height" << intrinsics.height;
  if (fisheye) {
    const std::vector<double>& p = intrinsics.parameters;
    WriteNumbers("projection_parameters", {"k2", "k3", "k4", "k5", "mu", "mv", "u0", "v0"},
                 {p[4], p[5], p[6], p[7], p[0], p[1], p[2], p[3]}, &file);
  } else {
    WriteNumbers("distortion_parameters", {"k1", "k2", "p1", "p2"}, radtan->distortion, &file);
    WriteNumbers("projection_parameters", {"fx", "fy", "cx", "cy"}, radtan->pinhole, &file);
  }
  return file.releaseAndGetString();
}

}  // namespace

std::vector<ExportedFile> VinsFusionFiles(const CalibrationResult& result) {
  std::vector<ExportedFile> files;
  cv::FileStorage main(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  main.writeComment("body_T_cam: p_imu = T * p_cam, metres. td: t_imu = t_cam + td, seconds.");
  std::vector<const SensorResult*> cameras;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.intrinsics) continue;
    const std::string text = CameraText(sensor);
    if (text.empty()) {
      main.writeComment(sensor.name + " is omitted: VINS-Fusion has no model with all its terms");
      continue;
    }
    const std::string number = std::to_string(cameras.size());
    main << "cam" + number + "_calib" << sensor.name + ".yaml"
         << "body_T_cam" + number << HomogeneousMatrix(sensor.calibration.T_imu_sensor);
    main.writeComment("td of " + sensor.name + ": " + FixedNumber(sensor.calibration.time_offset, 9));
    files.push_back({sensor.name + ".yaml", text});
    cameras.push_back(&sensor);
  }
  if (cameras.empty()) return {};
  main << "estimate_extrinsic" << 0 << "estimate_td" << 0 << "td" << cameras.front()->calibration.time_offset
       << "g_norm" << result.gravity.norm();
  if (cameras.size() > 1) main.writeComment("There is one td: that of the first camera.");
  files.insert(files.begin(), {"vins_fusion.yaml", main.releaseAndGetString()});
  return files;
}

}  // namespace mlic
