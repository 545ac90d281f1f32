// The part of result_file.h that reads.
#include <charconv>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/io/file_format.h"
#include "mlic_core/io/result/correction_files.h"
#include "mlic_core/io/result/ground_keys.h"
#include "mlic_core/io/result/in_use_keys.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/result/run_keys.h"
#include "mlic_core/io/rig/rig_parsing.h"
#include "mlic_core/io/yaml_reader.h"

namespace mlic {
namespace {

RigidTransform ReadPose(const YamlReader& pose) {
  const YamlReader translation = pose.Get("translation", "give [x, y, z] in metres");
  return {ParseQuaternion(pose.Get("rotation", "give [x, y, z, w]")),
          translation.Vector3("x, y, z in metres")};
}

// key: sigma or bound.
PoseSigma ReadSigma(const YamlReader& owner, const char* key) {
  PoseSigma sigma;
  if (!owner.Has(key)) return sigma;
  const YamlReader node = owner.Get(key);
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

std::vector<UnobservableDirection> ReadUnobservable(const YamlReader& node) {
  std::vector<UnobservableDirection> directions;
  if (!node.Has("unobservable")) return directions;
  for (const YamlReader& element : node.Get("unobservable").Elements()) {
    UnobservableDirection direction;
    const YamlReader quantity = element.Get("quantity", "give translation, rotation or time_offset");
    direction.quantity = static_cast<UnobservableDirection::Quantity>(quantity.Choice(QuantityNames()));
    if (element.Has("direction")) direction.direction = element.Get("direction").Vector3("of a unit vector");
    if (element.Has("sigma")) direction.sigma = element.Get("sigma").Number();
    if (direction.quantity == UnobservableDirection::Quantity::kRotation)
      direction.sigma /= kDegreesPerRadian;
    directions.push_back(direction);
  }
  return directions;
}

void ReadObservability(const YamlReader& node, SensorResult* sensor) {
  if (node.Has("observable")) {
    const YamlReader observable = node.Get("observable");
    if (observable.Has("translation"))
      sensor->translation_observable = ReadFlags(observable.Get("translation"));
    if (observable.Has("rotation")) sensor->rotation_observable = ReadFlags(observable.Get("rotation"));
    if (observable.Has("time_offset")) sensor->time_offset_observable = observable.Get("time_offset").Flag();
  }
  sensor->unobservable = ReadUnobservable(node);
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

SensorResult::Type ReadType(const YamlReader& node) {
  return static_cast<SensorResult::Type>(node.Get("type", "give lidar or camera").Choice(TypeNames()));
}

void ReadDrift(const YamlReader& node, SensorResult* sensor) {
  if (!node.Has("clock_drift_ppm")) return;
  sensor->calibration.clock_drift = 1e-6 * node.Get("clock_drift_ppm").Number();
  if (node.Has("clock_drift_sigma_ppm")) {
    sensor->drift_sigma = 1e-6 * node.Get("clock_drift_sigma_ppm").Number();
  }
  const YamlReader reference = node.Get("clock_reference_ns", "give the stamp at which time_offset holds");
  const std::string text = reference.Text();
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), sensor->clock_reference);
  if (error != std::errc() || end != text.data() + text.size()) {
    reference.Fail("expected a whole number of nanoseconds");
  }
}

SensorResult ReadSensor(const YamlReader& node) {
  SensorResult sensor;
  sensor.name = node.Name();
  sensor.type = ReadType(node);
  sensor.fixed = node.Has("verdict") && node.Get("verdict").Choice(SensorVerdictNames()) == 1;
  if (node.Has("frame_id")) sensor.frame_id = node.Get("frame_id").Text();
  sensor.calibration.T_imu_sensor =
      ReadPose(node.Get("T_imu_sensor", "give {translation: [x, y, z], rotation: [x, y, z, w]}"));
  if (node.Has("time_offset")) sensor.calibration.time_offset = node.Get("time_offset").Number();
  ReadDrift(node, &sensor);
  sensor.sigma = ReadSigma(node, "sigma");
  if (node.Has("bound")) sensor.bound = ReadSigma(node, "bound");
  sensor.in_use = ReadInUse(node);
  ReadObservability(node, &sensor);
  sensor.corrections = ReadCorrections(node);
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

bool IsRejected(const YamlReader& sensor) {
  return sensor.Has("verdict") && sensor.Get("verdict").Choice(SensorVerdictNames()) == 2;
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
  if (imu.Has("accelerometer_lag")) result->imu.accelerometer_lag = imu.Get("accelerometer_lag").Number();
  if (!imu.Has("axes")) return;
  ImuAlignment alignment;
  alignment.axes = static_cast<ImuAxes>(imu.Get("axes").Choice(ImuAxesNames()));
  if (imu.Has("alignment")) {
    const YamlReader given = imu.Get("alignment");
    alignment.estimated = ReadFlags(given.Get("estimated", "give three of true and false"));
    const auto axes = [&](const char* key) {
      std::vector<Eigen::Vector3d> read;
      if (!given.Has(key)) return read;
      for (const YamlReader& axis : given.Get(key).Elements())
        read.push_back(axis.Vector3("of a unit vector"));
      return read;
    };
    alignment.held = axes("held");
    alignment.of_accelerometer = axes("of_accelerometer");
    alignment.sigma = given.Get("sigma_deg", "give three numbers").Vector3("x, y, z") / kDegreesPerRadian;
  }
  result->alignment = alignment;
}

QualityCheck ReadCheck(const YamlReader& node) {
  QualityCheck check;
  check.name = node.Get("name", "give the check's name").Text();
  if (node.Has("sensor")) check.sensor = node.Get("sensor").Text();
  const YamlReader value = node.Get("value", "give a number, or .nan");
  check.value = value.Text() == ".nan" ? NAN : value.Number();
  check.limit = node.Get("limit", "give a number").Number();
  const bool most = !node.Has("bound") || node.Get("bound").Choice({"most", "least"}) == 0;
  check.bound = most ? QualityCheck::Bound::kMost : QualityCheck::Bound::kLeast;
  if (node.Has("unit")) check.unit = node.Get("unit").String();
  if (node.Has("remedy")) check.remedy = node.Get("remedy").String();
  return check;
}

std::vector<std::string> ReadLines(const YamlReader& root, const char* key) {
  std::vector<std::string> lines;
  if (!root.Has(key)) return lines;
  for (const YamlReader& line : root.Get(key).Elements()) lines.push_back(line.String());
  return lines;
}

PairResult ReadPair(const YamlReader& node) {
  PairResult pair;
  const std::size_t slash = node.Name().find('/');
  if (slash == std::string::npos) node.Fail("a pair is named A/B after its two sensors");
  pair.a = node.Name().substr(0, slash);
  pair.b = node.Name().substr(slash + 1);
  pair.T_a_b = ReadPose(node.Get("T_a_b", "give {translation: [x, y, z], rotation: [x, y, z, w]}"));
  pair.sigma = ReadSigma(node, "sigma");
  if (node.Has("bound")) pair.bound = ReadSigma(node, "bound");
  pair.unobservable = ReadUnobservable(node);
  pair.in_use = ReadInUse(node);
  return pair;
}

}  // namespace

CalibrationResult ReadCalibrationFile(const std::filesystem::path& path) {
  const YamlReader root = YamlReader::Open(path);
  root.CheckIsMap("a calibration file that begins with format: " + kResultFormat.Text());
  ReadFormatVersion(root, kResultFormat);
  CalibrationResult result;
  if (root.Has("verdict")) {
    result.verdict = static_cast<Verdict>(root.Get("verdict").Choice(VerdictNames()));
  } else {
    result.verdict = Verdict::kTrusted;
  }
  result.reasons = ReadLines(root, "reasons");
  result.warnings = ReadLines(root, "warnings");
  if (root.Has("checks")) {
    for (const YamlReader& check : root.Get("checks").Elements()) result.checks.push_back(ReadCheck(check));
  }
  result.run = ReadRun(root);
  if (root.Has("imu")) ReadImu(root.Get("imu"), &result);
  const YamlReader sensors = root.Get("sensors", "give the calibrated sensors, or {} for none");
  for (const YamlReader& sensor : sensors.Entries()) {
    if (IsRejected(sensor)) {
      const std::string reason = sensor.Has("reason") ? sensor.Get("reason").String() : "";
      result.rejected.push_back({sensor.Name(), ReadType(sensor), reason});
      if (sensor.Has("frame_id")) result.rejected.back().frame_id = sensor.Get("frame_id").Text();
    } else {
      result.sensors.push_back(ReadSensor(sensor));
    }
  }
  result.ground = ReadGround(root);
  if (root.Has("root")) result.root = root.Get("root").Text();
  if (root.Has("pairs")) {
    for (const YamlReader& pair : root.Get("pairs").Entries()) result.pairs.push_back(ReadPair(pair));
  }
  return result;
}

}  // namespace mlic
