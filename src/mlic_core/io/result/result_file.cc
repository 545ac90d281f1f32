#include "mlic_core/io/result/result_file.h"

#include "mlic_core/io/rig/rig_parsing.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/io/yaml_reader.h"

namespace mlic {
namespace {

constexpr double kDegreesPerRadian = 180.0 / M_PI;
const char* const kFormat = "mlic_calibration/1";

const std::vector<std::string>& QuantityNames() {
  static const std::vector<std::string> names{"translation", "rotation", "time_offset"};
  return names;
}

// In the order of ImuAxes.
const std::vector<std::string>& ImuAxesNames() {
  static const std::vector<std::string> names{"common", "gyroscope", "accelerometer"};
  return names;
}

std::string Fixed(const Eigen::Vector3d& v) {
  return "[" + FixedNumber(v.x(), 9) + ", " + FixedNumber(v.y(), 9) + ", " + FixedNumber(v.z(), 9) + "]";
}

std::string Short(const double* values, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + ShortNumber(values[i], 12);
  return "[" + text + "]";
}

std::string Short(const Eigen::Vector3d& v) { return Short(v.data(), 3); }

std::string RowByRow(const Eigen::Matrix3d& m) {
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

// Whose axes the IMU's are, and how the accelerometer's stand to the gyroscope's.
std::string AlignmentText(const std::optional<ImuAlignment>& alignment) {
  if (!alignment) return "";
  std::string text = "  axes: " + ImuAxesNames()[static_cast<std::size_t>(alignment->axes)] + "\n";
  if (alignment->axes == ImuAxes::kAccelerometer) return text;
  return text + "  alignment: {estimated: " + Flags(alignment->estimated) +
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
  text += std::string("    type: ") + (sensor.type == SensorResult::Type::kLidar ? "lidar" : "camera") + "\n";
  text += "    frame_id: " + QuotedYaml(sensor.frame_id) + "\n";
  text += "    T_imu_sensor: " + PoseText(sensor.calibration.T_imu_sensor) + "\n";
  text += "    sigma: " + SigmaText(sensor.sigma) + "\n";
  text += "    observable: {translation: " + Flags(sensor.translation_observable) +
          ", rotation: " + Flags(sensor.rotation_observable) +
          ", time_offset: " + (sensor.time_offset_observable ? "true" : "false") + "}\n";
  text += "    unobservable: " + UnobservableText(sensor.unobservable) + "\n";
  text += "    time_offset: " + FixedNumber(sensor.calibration.time_offset, 9) + "\n";
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

std::string ReasonsText(const std::vector<std::string>& reasons) {
  if (reasons.empty()) return "reasons: []\n";
  std::string text = "reasons:\n";
  for (const std::string& reason : reasons) text += "  - " + QuotedYaml(reason) + "\n";
  return text;
}

RigidTransform ReadPose(const YamlReader& pose) {
  const YamlReader translation = pose.Get("translation", "give [x, y, z] in metres");
  return {ParseQuaternion(pose.Get("rotation", "give [x, y, z, w]")),
          translation.Vector3("x, y, z in metres")};
}

PoseSigma ReadSigma(const YamlReader& owner) {
  PoseSigma sigma;
  if (!owner.Has("sigma")) return sigma;
  const YamlReader node = owner.Get("sigma");
  if (node.Has("translation")) sigma.translation = node.Get("translation").Vector3("in metres");
  if (node.Has("rotation_deg")) {
    sigma.rotation = node.Get("rotation_deg").Vector3("in degrees") / kDegreesPerRadian;
  }
  if (node.Has("time_offset")) sigma.time_offset = node.Get("time_offset").Number();
  return sigma;
}

std::array<bool, 3> ReadFlags(const YamlReader& flags) {
  const std::vector<YamlReader> elements = flags.Elements();
  if (elements.size() != 3) flags.Fail("expected 3 flags, true or false");
  return {elements[0].Flag(), elements[1].Flag(), elements[2].Flag()};
}

void ReadObservability(const YamlReader& node, SensorResult* sensor) {
  if (node.Has("observable")) {
    const YamlReader observable = node.Get("observable");
    if (observable.Has("translation"))
      sensor->translation_observable = ReadFlags(observable.Get("translation"));
    if (observable.Has("rotation")) sensor->rotation_observable = ReadFlags(observable.Get("rotation"));
    if (observable.Has("time_offset")) sensor->time_offset_observable = observable.Get("time_offset").Flag();
  }
  if (!node.Has("unobservable")) return;
  for (const YamlReader& element : node.Get("unobservable").Elements()) {
    UnobservableDirection direction;
    const YamlReader quantity = element.Get("quantity", "give translation, rotation or time_offset");
    direction.quantity = static_cast<UnobservableDirection::Quantity>(quantity.Choice(QuantityNames()));
    if (element.Has("direction")) direction.direction = element.Get("direction").Vector3("of a unit vector");
    if (element.Has("sigma")) direction.sigma = element.Get("sigma").Number();
    if (direction.quantity == UnobservableDirection::Quantity::kRotation)
      direction.sigma /= kDegreesPerRadian;
    sensor->unobservable.push_back(direction);
  }
}

CameraIntrinsics ReadIntrinsics(const YamlReader& node) {
  CameraIntrinsics intrinsics;
  const YamlReader model = node.Get("model", "give the camera model");
  intrinsics.model = static_cast<CameraModel>(model.Choice(CameraModelNames()));
  if (node.Has("image_size")) {
    const std::vector<double> size = node.Get("image_size").Numbers(2, "width and height in pixels");
    intrinsics.width = static_cast<int>(size[0]);
    intrinsics.height = static_cast<int>(size[1]);
  }
  const std::size_t count = 4 + DistortionCount(intrinsics.model);
  intrinsics.parameters = node.Get("params", "give fx fy cx cy and the distortion")
                              .Numbers(count, "(fx fy cx cy and the distortion of this model)");
  return intrinsics;
}

// Sigmas and held parameters stand beside the intrinsics.
void ReadIntrinsicsQuality(const YamlReader& node, SensorResult* sensor) {
  const std::vector<std::string> names = ParameterNames(sensor->intrinsics->model);
  if (node.Has("intrinsics_sigma")) {
    sensor->intrinsics_sigma =
        node.Get("intrinsics_sigma").Numbers(names.size(), "(the sigma of each parameter of this model)");
  }
  if (!node.Has("intrinsics_held")) return;
  for (const YamlReader& name : node.Get("intrinsics_held").Elements()) {
    sensor->intrinsics_fixed.resize(names.size(), false);
    sensor->intrinsics_fixed[name.Choice(names)] = true;
  }
}

SensorResult ReadSensor(const YamlReader& node) {
  SensorResult sensor;
  sensor.name = node.Name();
  const std::size_t type = node.Get("type", "give lidar or camera").Choice({"lidar", "camera"});
  sensor.type = type == 0 ? SensorResult::Type::kLidar : SensorResult::Type::kCamera;
  if (node.Has("frame_id")) sensor.frame_id = node.Get("frame_id").Text();
  sensor.calibration.T_imu_sensor =
      ReadPose(node.Get("T_imu_sensor", "give {translation: [x, y, z], rotation: [x, y, z, w]}"));
  if (node.Has("time_offset")) sensor.calibration.time_offset = node.Get("time_offset").Number();
  sensor.sigma = ReadSigma(node);
  ReadObservability(node, &sensor);
  if (node.Has("intrinsics")) {
    sensor.intrinsics = ReadIntrinsics(node.Get("intrinsics"));
    ReadIntrinsicsQuality(node, &sensor);
  }
  if (node.Has("rolling_shutter_readout")) {
    sensor.rolling_shutter_readout = node.Get("rolling_shutter_readout").Number();
  }
  if (node.Has("readout_sigma")) sensor.readout_sigma = node.Get("readout_sigma").Number();
  if (node.Has("held_out_matches")) {
    const YamlReader held_out = node.Get("held_out_matches");
    const auto number = [&](const char* key) { return held_out.Get(key, "give a number").Number(); };
    sensor.held_out = {static_cast<std::size_t>(number("count")), number("median"), number("rms")};
  }
  return sensor;
}

void ReadImu(const YamlReader& imu, CalibrationResult* result) {
  const auto vector = [&](const char* key, Eigen::Vector3d* value) {
    if (imu.Has(key)) *value = imu.Get(key).Vector3("x, y, z");
  };
  const auto matrix = [&](const char* key, Eigen::Matrix3d* value) {
    if (!imu.Has(key)) return;
    const std::vector<double> rows = imu.Get(key).Numbers(9, "of a matrix, row by row");
    for (int i = 0; i < 9; ++i) (*value)(i / 3, i % 3) = rows[i];
  };
  if (imu.Has("frame_id")) result->imu_frame_id = imu.Get("frame_id").Text();
  vector("gyroscope_bias", &result->imu.gyroscope_bias);
  vector("accelerometer_bias", &result->imu.accelerometer_bias);
  vector("gravity", &result->gravity);
  matrix("gyroscope_matrix", &result->imu.gyroscope_matrix);
  matrix("accelerometer_matrix", &result->imu.accelerometer_matrix);
  if (!imu.Has("axes")) return;
  ImuAlignment alignment;
  alignment.axes = static_cast<ImuAxes>(imu.Get("axes").Choice(ImuAxesNames()));
  if (imu.Has("alignment")) {
    const YamlReader given = imu.Get("alignment");
    alignment.estimated = ReadFlags(given.Get("estimated", "give three of true and false"));
    alignment.sigma = given.Get("sigma_deg", "give three numbers").Vector3("x, y, z") / kDegreesPerRadian;
  }
  result->alignment = alignment;
}

PairResult ReadPair(const YamlReader& node) {
  PairResult pair;
  const std::size_t slash = node.Name().find('/');
  if (slash == std::string::npos) node.Fail("a pair is named A/B after its two sensors");
  pair.a = node.Name().substr(0, slash);
  pair.b = node.Name().substr(slash + 1);
  pair.T_a_b = ReadPose(node.Get("T_a_b", "give {translation: [x, y, z], rotation: [x, y, z, w]}"));
  pair.sigma = ReadSigma(node);
  return pair;
}

}  // namespace

void WriteCalibrationFile(const std::filesystem::path& path, const CalibrationResult& result) {
  std::string text = std::string("format: ") + kFormat + "\n";
  text += std::string("verdict: ") + (result.trusted ? "trusted" : "refused") + "\n";
  text += ReasonsText(result.reasons);
  text += "imu:\n  frame_id: " + QuotedYaml(result.imu_frame_id) + "\n";
  text += "  gyroscope_bias: " + Short(result.imu.gyroscope_bias) + "\n";
  text += "  accelerometer_bias: " + Short(result.imu.accelerometer_bias) + "\n";
  text += "  gravity: " + Short(result.gravity) + "  # in the map\n";
  text += "  gyroscope_matrix: " + RowByRow(result.imu.gyroscope_matrix) +
          "  # measured = matrix * true + bias\n";
  text += "  accelerometer_matrix: " + RowByRow(result.imu.accelerometer_matrix) + "\n";
  text += AlignmentText(result.alignment);
  text += "# p_imu = T_imu_sensor * p_sensor, t_imu = t_sensor + time_offset; metres, seconds, x y z w.\n";
  text += "# Sigmas along the axes of the IMU (pairs: of the first sensor), of rotations in degrees.\n";
  text += result.sensors.empty() ? "sensors: {}\n" : "sensors:\n";
  for (const SensorResult& sensor : result.sensors) text += SensorText(sensor);
  text += result.pairs.empty() ? "pairs: {}\n" : "pairs:\n";
  for (const PairResult& pair : result.pairs) {
    text += "  " + pair.a + "/" + pair.b + ": {T_a_b: " + PoseText(pair.T_a_b) +
            ", sigma: " + SigmaText(pair.sigma) + "}\n";
  }
  WriteFileAtomically(path, text);
}

CalibrationResult ReadCalibrationFile(const std::filesystem::path& path) {
  const YamlReader root = YamlReader::Open(path);
  root.CheckIsMap(std::string("a calibration file that begins with format: ") + kFormat);
  root.Get("format", std::string("expected format: ") + kFormat).Choice({kFormat});
  CalibrationResult result;
  result.trusted = !root.Has("verdict") || root.Get("verdict").Choice({"trusted", "refused"}) == 0;
  if (root.Has("reasons")) {
    for (const YamlReader& reason : root.Get("reasons").Elements()) result.reasons.push_back(reason.String());
  }
  if (root.Has("imu")) ReadImu(root.Get("imu"), &result);
  const YamlReader sensors = root.Get("sensors", "give the calibrated sensors, or {} for none");
  for (const YamlReader& sensor : sensors.Entries()) result.sensors.push_back(ReadSensor(sensor));
  if (root.Has("pairs")) {
    for (const YamlReader& pair : root.Get("pairs").Entries()) result.pairs.push_back(ReadPair(pair));
  }
  return result;
}

}  // namespace mlic
