#include "mlic_core/io/result/kalibr_camchain.h"

#include <algorithm>

#include "mlic_core/io/result/number_list.h"
#include "mlic_core/io/result/radtan_fit.h"
#include "mlic_core/io/rig/rig_parsing.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/io/yaml_reader.h"

namespace mlic {
namespace {

// An intrinsic model in Kalibr's words; no camera_model where Kalibr has none that fits.
struct KalibrModel {
  std::string camera_model;
  std::string distortion_model;
  std::vector<double> intrinsics;
  std::vector<double> distortion;
  std::string remark;  // what is not exact
};

KalibrModel ToKalibr(const CameraIntrinsics& camera) {
  const std::vector<double>& p = camera.parameters;
  const std::vector<double> pinhole(p.begin(), p.begin() + 4);
  switch (camera.model) {
    case CameraModel::kPlumbBob:
    case CameraModel::kRationalPolynomial:
      if (const auto radtan = AsRadtan(camera)) {
        return {"pinhole", "radtan", radtan->pinhole, radtan->distortion, radtan->remark};
      }
      return {};
    case CameraModel::kEquidistant:
      return {"pinhole", "equidistant", pinhole, {p.begin() + 4, p.end()}, ""};
    case CameraModel::kDoubleSphere:
      return {"ds", "none", {p[4], p[5], p[0], p[1], p[2], p[3]}, {}, ""};
  }
  return {};
}

// Indented as OpenCV's reader needs it.
std::string MatrixText(const std::string& name, const RigidTransform& transform) {
  const Eigen::Matrix3d R = transform.rotation.toRotationMatrix();
  std::string text = "  " + name + ":\n";
  for (int row = 0; row < 3; ++row) {
    text += "    - [" + FixedNumber(R(row, 0), 12) + ", " + FixedNumber(R(row, 1), 12) + ", " +
            FixedNumber(R(row, 2), 12) + ", " + FixedNumber(transform.translation[row], 12) + "]\n";
  }
  return text + "    - [0.0, 0.0, 0.0, 1.0]\n";
}

}  // namespace

std::string KalibrCamchainText(const CalibrationResult& result, CamchainReader reader) {
  const bool openvins = reader == CamchainReader::kOpenVins;
  std::string text = openvins ? "%YAML:1.0\n\n" : "";
  text +=
      "# p_cam = T_cam_imu * p_imu, p_cam = T_cn_cnm1 * p of the camera before; metres.\n"
      "# t_imu = t_cam + timeshift_cam_imu, seconds.\n";
  const SensorResult* previous = nullptr;
  int number = 0;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.intrinsics) continue;
    const CameraIntrinsics& camera = *sensor.intrinsics;
    const KalibrModel model = ToKalibr(camera);
    if (model.camera_model.empty() || (openvins && model.camera_model != "pinhole")) {
      text += "# " + sensor.name + " is omitted: " + (openvins ? "OpenVINS" : "Kalibr") + " has no " +
              CameraModelNames()[static_cast<std::size_t>(camera.model)] + " with all its terms\n";
      continue;
    }
    const RigidTransform T_cam_imu = sensor.calibration.T_imu_sensor.Inverse();
    text +=
        "cam" + std::to_string(number++) + ":  # " + sensor.name + "\n" + MatrixText("T_cam_imu", T_cam_imu);
    if (previous != nullptr) {
      text += MatrixText("T_cn_cnm1", T_cam_imu * previous->calibration.T_imu_sensor);
    }
    if (!model.remark.empty()) text += "  # " + model.remark + "\n";
    text += "  camera_model: " + model.camera_model +
            "\n  distortion_coeffs: " + NumberList(model.distortion) +
            "\n  distortion_model: " + model.distortion_model +
            "\n  intrinsics: " + NumberList(model.intrinsics) + "\n  resolution: [" +
            std::to_string(camera.width) + ", " + std::to_string(camera.height) + "]\n";
    if (!sensor.topic.empty()) text += "  rostopic: " + QuotedYaml(sensor.topic) + "\n";
    text += "  timeshift_cam_imu: " + FixedNumber(sensor.calibration.time_offset, 9) + "\n";
    previous = &sensor;
  }
  const bool none = std::none_of(result.sensors.begin(), result.sensors.end(),
                                 [](const SensorResult& sensor) { return sensor.intrinsics.has_value(); });
  return none ? "" : text;
}

void WriteKalibrCamchain(const std::filesystem::path& path, const CalibrationResult& result) {
  const std::string text = KalibrCamchainText(result, CamchainReader::kKalibr);
  if (!text.empty()) WriteFileAtomically(path, text);
}

}  // namespace mlic
