#include "mlic_core/io/result/kalibr_camchain.h"

#include <algorithm>

#include "mlic_core/io/result/radtan_fit.h"
#include "mlic_core/io/rig/rig_parsing.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/io/yaml_reader.h"

namespace mlic {
namespace {

// from: definition, docs/outputs.md.
constexpr double kLargestMeanError = 0.2;  // px, of a camera that is written as a model with fewer terms

// An intrinsic model in Kalibr's words; no camera_model where Kalibr has none that fits.
struct KalibrModel {
  std::string camera_model;
  std::string distortion_model;
  std::vector<double> intrinsics;
  std::vector<double> distortion;
  std::string remark;  // what is not exact
};

// radtan is k1 k2 p1 p2, with neither k3 nor a denominator.
KalibrModel ToRadtan(const CameraIntrinsics& camera) {
  const std::vector<double>& p = camera.parameters;
  if (std::all_of(p.begin() + 8, p.end(), [](double value) { return value == 0.0; })) {
    return {"pinhole", "radtan", {p.begin(), p.begin() + 4}, {p.begin() + 4, p.begin() + 8}, ""};
  }
  const RadtanFit fit = FitRadtan(camera);
  if (!(fit.mean < kLargestMeanError)) return {};
  const std::vector<double>& q = fit.intrinsics.parameters;
  return {"pinhole",
          "radtan",
          {q.begin(), q.begin() + 4},
          {q.begin() + 4, q.begin() + 8},
          "fitted to the camera's " + CameraModelNames()[static_cast<std::size_t>(camera.model)] +
              ", of which radtan lacks terms: pixels off by " + FixedNumber(fit.mean, 3) + " in the mean, " +
              FixedNumber(fit.largest, 3) + " at most"};
}

KalibrModel ToKalibr(const CameraIntrinsics& camera) {
  const std::vector<double>& p = camera.parameters;
  const std::vector<double> pinhole(p.begin(), p.begin() + 4);
  switch (camera.model) {
    case CameraModel::kPlumbBob:
    case CameraModel::kRationalPolynomial:
      return ToRadtan(camera);
    case CameraModel::kEquidistant:
      return {"pinhole", "equidistant", pinhole, {p.begin() + 4, p.end()}, ""};
    case CameraModel::kDoubleSphere:
      return {"ds", "none", {p[4], p[5], p[0], p[1], p[2], p[3]}, {}, ""};
  }
  return {};
}

std::string List(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + ShortNumber(value, 12);
  return "[" + text + "]";
}

std::string MatrixText(const std::string& name, const RigidTransform& transform) {
  const Eigen::Matrix3d R = transform.rotation.toRotationMatrix();
  std::string text = "  " + name + ":\n";
  for (int row = 0; row < 3; ++row) {
    text += "  - [" + FixedNumber(R(row, 0), 12) + ", " + FixedNumber(R(row, 1), 12) + ", " +
            FixedNumber(R(row, 2), 12) + ", " + FixedNumber(transform.translation[row], 9) + "]\n";
  }
  return text + "  - [0.0, 0.0, 0.0, 1.0]\n";
}

}  // namespace

std::string KalibrCamchainText(const CalibrationResult& result) {
  std::string text;
  const SensorResult* previous = nullptr;
  int number = 0;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.intrinsics) continue;
    const CameraIntrinsics& camera = *sensor.intrinsics;
    const KalibrModel model = ToKalibr(camera);
    if (model.camera_model.empty()) {
      text += "# " + sensor.name + " is omitted: Kalibr has no " +
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
    text += "  camera_model: " + model.camera_model + "\n  distortion_coeffs: " + List(model.distortion) +
            "\n  distortion_model: " + model.distortion_model + "\n  intrinsics: " + List(model.intrinsics) +
            "\n  resolution: [" + std::to_string(camera.width) + ", " + std::to_string(camera.height) + "]\n";
    if (!sensor.topic.empty()) text += "  rostopic: " + QuotedYaml(sensor.topic) + "\n";
    text += "  timeshift_cam_imu: " + FixedNumber(sensor.calibration.time_offset, 9) + "\n";
    previous = &sensor;
  }
  return text;
}

void WriteKalibrCamchain(const std::filesystem::path& path, const CalibrationResult& result) {
  const std::string text = KalibrCamchainText(result);
  if (!text.empty()) WriteFileAtomically(path, text);
}

}  // namespace mlic
