#include "mlic_core/io/result/result_file.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/io/file_format.h"
#include "mlic_core/io/result/correction_files.h"
#include "mlic_core/io/result/ground_keys.h"
#include "mlic_core/io/result/in_use_keys.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/result/run_keys.h"
#include "mlic_core/io/rig/rig_parsing.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

std::string Fixed(const Eigen::Vector3d& v) {
  return "[" + FixedNumber(v.x(), 9) + ", " + FixedNumber(v.y(), 9) + ", " + FixedNumber(v.z(), 9) + "]";
}

std::string Short(const double* values, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + ShortNumber(values[i], 12);
  return "[" + text + "]";
}

std::string Short(const Eigen::Vector3d& v) { return Short(v.data(), 3); }

std::string ShortRowByRow(const Eigen::Matrix3d& m) {
  const Eigen::Matrix3d transposed = m.transpose();  // Eigen stores column by column
  return Short(transposed.data(), 9);
}

std::string Flags(const std::array<bool, 3>& flags) {
  std::string text;
  for (const bool flag : flags) text += (text.empty() ? "" : ", ") + std::string(flag ? "true" : "false");
  return "[" + text + "]";
}

std::string PoseText(const RigidTransform& pose) {
  const double sign = pose.rotation.w() < 0.0 ? -1.0 : 1.0;  // one of the two equal quaternions
  const Eigen::Vector4d q = sign * pose.rotation.normalized().coeffs();
  return "{translation: " + Fixed(pose.translation) + ", rotation: [" + FixedNumber(q[0], 12) + ", " +
         FixedNumber(q[1], 12) + ", " + FixedNumber(q[2], 12) + ", " + FixedNumber(q[3], 12) + "]}";
}

std::string SigmaText(const PoseSigma& sigma) {
  return "{translation: " + Short(sigma.translation) +
         ", rotation_deg: " + Short(kDegreesPerRadian * sigma.rotation) +
         ", time_offset: " + ShortNumber(sigma.time_offset, 12) + "}";
}

std::string AxesText(const std::vector<Eigen::Vector3d>& axes) {
  std::string text;
  for (const Eigen::Vector3d& axis : axes) text += (text.empty() ? "" : ", ") + Fixed(axis);
  return "[" + text + "]";
}

// Whose axes the IMU's are, and how the accelerometer's stand to the gyroscope's.
std::string AlignmentText(const std::optional<ImuAlignment>& alignment) {
  if (!alignment) return "";
  return "  axes: " + ImuAxesNames()[static_cast<std::size_t>(alignment->axes)] +
         "\n  alignment: {estimated: " + Flags(alignment->estimated) +
         ", held: " + AxesText(alignment->held) +
         ", of_accelerometer: " + AxesText(alignment->of_accelerometer) +
         ", sigma_deg: " + Short(kDegreesPerRadian * alignment->sigma) + "}\n";
}

std::string UnobservableText(const std::vector<UnobservableDirection>& directions) {
  std::string text;
  for (const UnobservableDirection& direction : directions) {
    const bool rotation = direction.quantity == UnobservableDirection::Quantity::kRotation;
    text += text.empty() ? "" : ", ";
    text += "{quantity: " + QuantityNames()[static_cast<std::size_t>(direction.quantity)];
    if (direction.quantity != UnobservableDirection::Quantity::kTimeOffset) {
      text += ", direction: " + Fixed(direction.direction);
    }
    text += ", sigma: " + ShortNumber(direction.sigma * (rotation ? kDegreesPerRadian : 1.0), 12) + "}";
  }
  return "[" + text + "]";
}

std::string HeldNames(const SensorResult& sensor) {
  const std::vector<std::string> names = ParameterNames(sensor.intrinsics->model);
  std::string text;
  for (std::size_t i = 0; i < sensor.intrinsics_fixed.size() && i < names.size(); ++i) {
    if (sensor.intrinsics_fixed[i]) text += (text.empty() ? "" : ", ") + names[i];
  }
  return "[" + text + "]";
}

std::string SensorText(const SensorResult& sensor) {
  std::string text = "  " + sensor.name + ":\n";
  text += "    type: " + TypeNames()[static_cast<std::size_t>(sensor.type)] + "\n";
  text += std::string("    verdict: ") + (sensor.fixed ? "held" : "trusted") + "\n";
  text += "    frame_id: " + QuotedYaml(sensor.frame_id) + "\n";
  text += "    T_imu_sensor: " + PoseText(sensor.calibration.T_imu_sensor) + "\n";
  text += "    sigma: " + SigmaText(sensor.sigma) + "\n";
  if (sensor.bound) text += "    bound: " + SigmaText(*sensor.bound) + "\n";
  text += "    observable: {translation: " + Flags(sensor.translation_observable) +
          ", rotation: " + Flags(sensor.rotation_observable) +
          ", time_offset: " + (sensor.time_offset_observable ? "true" : "false") + "}\n";
  text += "    unobservable: " + UnobservableText(sensor.unobservable) + "\n";
  if (!sensor.in_use.empty()) text += "    use: " + InUseText(sensor.in_use) + "\n";
  text += "    time_offset: " + FixedNumber(sensor.calibration.time_offset, 9) + "\n";
  if (sensor.calibration.clock_drift) {
    text += "    clock_drift_ppm: " + FixedNumber(1e6 * *sensor.calibration.clock_drift, 4) +
            "  # t_imu = t_sensor + time_offset + 1e-6 * clock_drift_ppm * (t_sensor - 1e-9 * "
            "clock_reference_ns)\n";
    text += "    clock_drift_sigma_ppm: " + ShortNumber(1e6 * sensor.drift_sigma, 6) + "\n";
    text += "    clock_reference_ns: " + std::to_string(sensor.clock_reference) + "\n";
  }
  if (sensor.corrections.Any()) text += "    corrections: " + CorrectionsText(sensor.corrections) + "\n";
  if (sensor.intrinsics) {
    const CameraIntrinsics& intrinsics = *sensor.intrinsics;
    text += "    intrinsics: {model: " + CameraModelNames()[static_cast<std::size_t>(intrinsics.model)] +
            ", image_size: [" + std::to_string(intrinsics.width) + ", " + std::to_string(intrinsics.height) +
            "], params: " + Short(intrinsics.parameters.data(), intrinsics.parameters.size()) + "}\n";
    if (!sensor.intrinsics_sigma.empty()) {
      text +=
          "    intrinsics_sigma: " + Short(sensor.intrinsics_sigma.data(), sensor.intrinsics_sigma.size()) +
          "\n";
    }
    text += "    intrinsics_held: " + HeldNames(sensor) + "\n";
  }
  if (sensor.rolling_shutter_readout) {
    text += "    rolling_shutter_readout: " + FixedNumber(*sensor.rolling_shutter_readout, 9) + "\n";
  }
  if (sensor.readout_sigma) text += "    readout_sigma: " + ShortNumber(*sensor.readout_sigma, 12) + "\n";
  if (sensor.held_out) {
    text += "    held_out_matches: {count: " + std::to_string(sensor.held_out->count) +
            ", median: " + FixedNumber(sensor.held_out->median, 4) +
            ", rms: " + FixedNumber(sensor.held_out->rms, 4) +
            "}  # px, with the LiDAR map, used by no solve\n";
  }
  return text;
}

// A sensor may have been rejected for several reasons.
std::string RejectedText(const std::vector<RejectedSensor>& rejected) {
  std::string text;
  for (std::size_t i = 0; i < rejected.size(); ++i) {
    const auto of_same = [&](const RejectedSensor& other) { return other.name == rejected[i].name; };
    if (std::any_of(rejected.begin(), rejected.begin() + i, of_same)) continue;
    std::string reasons;
    for (const RejectedSensor& other : rejected) {
      if (of_same(other)) reasons += (reasons.empty() ? "" : "; ") + other.reason;
    }
    text += "  " + rejected[i].name +
            ":\n    type: " + TypeNames()[static_cast<std::size_t>(rejected[i].type)] +
            "\n    verdict: rejected\n    reason: " + QuotedYaml(reasons) + "\n";
    if (!rejected[i].frame_id.empty()) text += "    frame_id: " + QuotedYaml(rejected[i].frame_id) + "\n";
  }
  return text;
}

std::string LinesText(const std::string& key, const std::vector<std::string>& lines) {
  if (lines.empty()) return key + ": []\n";
  std::string text = key + ":\n";
  for (const std::string& line : lines) text += "  - " + QuotedYaml(line) + "\n";
  return text;
}

std::string ChecksText(const std::vector<QualityCheck>& checks) {
  if (checks.empty()) return "checks: []\n";
  std::string text = "checks:\n";
  for (const QualityCheck& check : checks) {
    text += "  - {name: " + check.name;
    if (!check.sensor.empty()) text += ", sensor: " + check.sensor;
    text += ", value: " + (std::isfinite(check.value) ? ShortNumber(check.value, 6) : ".nan") +
            ", limit: " + ShortNumber(check.limit, 6) +
            ", bound: " + (check.bound == QualityCheck::Bound::kMost ? "most" : "least") +
            ", unit: " + QuotedYaml(check.unit) + ", passed: " + (check.Passed() ? "true" : "false") +
            ", remedy: " + QuotedYaml(check.remedy) + "}\n";
  }
  return text;
}

}  // namespace

void WriteCalibrationFile(const std::filesystem::path& path, const CalibrationResult& result) {
  std::string text = "format: " + kResultFormat.Text() + "\n";
  text += "verdict: " + VerdictName(result.verdict) + "\n";
  text += LinesText("reasons", result.reasons);
  text += LinesText("warnings", result.warnings);
  text += ChecksText(result.checks);
  text += RunText(result.run);
  text += "imu:\n  frame_id: " + QuotedYaml(result.imu_frame_id) + "\n";
  text += "  gyroscope_bias: " + Short(result.imu.gyroscope_bias) + "\n";
  text += "  accelerometer_bias: " + Short(result.imu.accelerometer_bias) + "\n";
  text += "  gravity: " + Short(result.gravity) + "  # in the map\n";
  text += "  gyroscope_matrix: " + ShortRowByRow(result.imu.gyroscope_matrix) +
          "  # measured = matrix * true + bias\n";
  text += "  accelerometer_matrix: " + ShortRowByRow(result.imu.accelerometer_matrix) + "\n";
  text += "  accelerometer_lag: " + ShortNumber(result.imu.accelerometer_lag, 6) +
          "  # s, by which it is later than the gyroscope under the same stamp\n";
  text += AlignmentText(result.alignment);
  text += GroundText(result.ground);
  text += "# p_imu = T_imu_sensor * p_sensor, t_imu = t_sensor + time_offset; metres, seconds, x y z w.\n";
  text += "# Sigmas along the axes of the IMU (pairs: of the first sensor), of rotations in degrees.\n";
  text += result.sensors.empty() && result.rejected.empty() ? "sensors: {}\n" : "sensors:\n";
  for (const SensorResult& sensor : result.sensors) text += SensorText(sensor);
  text += RejectedText(result.rejected);
  if (!result.root.empty()) {
    text += "root: " + result.root + "  # the launch file and the URDF are about it, not about the IMU\n";
  }
  text += result.pairs.empty() ? "pairs: {}\n" : "pairs:\n";
  for (const PairResult& pair : result.pairs) {
    text += "  " + pair.a + "/" + pair.b + ": {T_a_b: " + PoseText(pair.T_a_b) +
            ", sigma: " + SigmaText(pair.sigma) + (pair.bound ? ", bound: " + SigmaText(*pair.bound) : "") +
            (result.root.empty() ? "" : ", unobservable: " + UnobservableText(pair.unobservable)) +
            (pair.in_use.empty() ? "" : ", use: " + InUseText(pair.in_use)) + "}\n";
  }
  WriteFileAtomically(path, text);
}

}  // namespace mlic
