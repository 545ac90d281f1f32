#include "mlic_core/io/rig/rig_file.h"

#include <map>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/file_format.h"
#include "mlic_core/io/rig/rig_parsing.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/io/yaml_reader.h"

namespace mlic {
namespace {

// What stands in a drafted rig file for a value that the bag does not tell.
constexpr const char* kToFillIn = "???";

// All that is left to fill in of a drafted rig, in one error.
void CheckFilledIn(const YamlReader& root) {
  const std::vector<YamlReader> open = root.Find(kToFillIn);
  if (open.empty()) return;
  std::string places;
  for (const YamlReader& place : open) places += (places.empty() ? "" : ", ") + place.Path();
  root.Fail("not filled in: replace ??? in " + places + ", or take these sensors out");
}

// Finds values that may be used once only, in all enabled sensors and the IMU.
class UniqueValues {
 public:
  explicit UniqueValues(std::string meaning) : meaning_(std::move(meaning)) {}
  void Add(const std::string& value, const YamlReader& place) {
    if (value.empty()) return;
    const auto [first, inserted] = owner_.emplace(value, place.Where());
    if (!inserted) place.Fail(meaning_ + " '" + value + "' is already used at " + first->second);
  }

 private:
  std::string meaning_;
  std::map<std::string, std::string> owner_;
};

std::string List(const Eigen::Vector3d& v) {
  return "[" + FixedNumber(v.x(), 9) + ", " + FixedNumber(v.y(), 9) + ", " + FixedNumber(v.z(), 9) + "]";
}

std::string ShortList(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + ShortNumber(value, 12);
  return "[" + text + "]";
}

std::string RotationText(const Eigen::Quaterniond& q) {
  const Eigen::Vector3d rpy = ToRollPitchYaw(q);
  // Near gimbal lock the angles lose digits: the quaternion then says it exactly.
  if (AngleBetween(FromRollPitchYaw(rpy), q) < 1e-10) return "rpy_deg: " + List(rpy * kDegreesPerRadian);
  return "rotation: " + ShortList({q.x(), q.y(), q.z(), q.w()});
}

// Quoted where YAML would read something else than the text.
std::string Scalar(const std::string& text) {
  YAML::Emitter emitter;
  emitter << text;
  return emitter.c_str();
}

// Of a fixed sensor only what counts: what is left out is exact.
template <typename Config>
std::string SigmaText(const Config& sensor) {
  const auto list = [](const Eigen::Vector3d& v) { return ShortList({v.x(), v.y(), v.z()}); };
  Eigen::Vector3d position = sensor.guess->sigma_translation, angle = sensor.guess->sigma_rotation;
  if (sensor.fixed) {
    const HeldSigma held = sensor.held_sigma.value_or(HeldSigma());
    position = held.translation;
    angle = held.rotation;
  }
  std::string text;
  if (!position.isZero()) text += "xyz: " + list(position);
  if (!angle.isZero()) text += (text.empty() ? "" : ", ") + ("rpy_deg: " + list(angle * kDegreesPerRadian));
  return text.empty() ? "" : "    sigma: {" + text + "}\n";
}

template <typename Config>
std::string SensorText(const Config& sensor) {
  std::string text = "  " + sensor.name + ":\n    topic: " + Scalar(sensor.topic) + "\n";
  if (!sensor.frame_id.empty()) text += "    frame_id: " + Scalar(sensor.frame_id) + "\n";
  if (sensor.guess) {
    const ExtrinsicGuess& guess = *sensor.guess;
    text += "    T_imu_sensor: {xyz: " + List(guess.T_imu_sensor.translation) + ", " +
            RotationText(guess.T_imu_sensor.rotation) + "}\n";
    text += SigmaText(sensor);
  }
  if (sensor.time_offset) text += "    time_offset: " + ShortNumber(*sensor.time_offset, 12) + "\n";
  if (sensor.fixed) text += "    fixed: true\n";
  return text;
}

std::string CameraText(const CameraConfig& camera) {
  std::string text = SensorText(camera);
  text += "    model: " + CameraModelNames()[static_cast<std::size_t>(camera.model)] + "\n";
  if (camera.fov_deg) text += "    fov_deg: " + ShortNumber(*camera.fov_deg, 12) + "\n";
  if (!camera.fov_deg && !camera.intrinsics) {
    text += std::string("    fov_deg: ") + kToFillIn +
            "  # horizontal field of view, degrees; is the model above the lens's?\n";
  }
  if (camera.intrinsics) text += "    intrinsics: " + ShortList(*camera.intrinsics) + "\n";
  if (camera.intrinsics_fixed) text += "    intrinsics_fixed: true\n";
  text += "    shutter: " + ShutterNames()[static_cast<std::size_t>(camera.shutter)] + "\n";
  if (!camera.mask.empty()) text += "    mask: " + Scalar(camera.mask) + "\n";
  return text;
}

}  // namespace

Rig LoadRigFile(const std::filesystem::path& path) {
  const YamlReader root = YamlReader::Open(path);
  ReadFormatVersion(root, kRigFormat);
  root.CheckKeys({"format", "imu", "lidars", "cameras"});
  CheckFilledIn(root);
  Rig rig;
  const YamlReader imu = root.Get("imu", "give imu: {topic: ...}");
  rig.imu = ParseImu(imu);
  UniqueValues names("the name"), topics("the topic"), frames("the frame_id");
  topics.Add(rig.imu.topic, imu);
  frames.Add(rig.imu.frame_id, imu);
  const auto add = [&](const auto& config, const YamlReader& place, bool enabled, auto* list) {
    names.Add(config.name, place);
    if (!enabled) return;
    topics.Add(config.topic, place);
    frames.Add(config.frame_id, place);
    list->push_back(config);
  };
  bool enabled = true;
  if (root.Has("lidars")) {
    for (const YamlReader& lidar : root.Get("lidars").Entries()) {
      const LidarConfig config = ParseLidar(lidar, &enabled);
      add(config, lidar, enabled, &rig.lidars);
    }
  }
  if (root.Has("cameras")) {
    for (const YamlReader& camera : root.Get("cameras").Entries()) {
      const CameraConfig config = ParseCamera(camera, &enabled);
      add(config, camera, enabled, &rig.cameras);
      if (enabled && !config.fov_deg && !config.intrinsics) {
        camera.Fail(
            "neither intrinsics nor fov_deg; give the horizontal field of view in degrees as fov_deg");
      }
    }
  }
  if (rig.lidars.empty() && rig.cameras.empty()) {
    root.Fail("no enabled sensor; give at least one under lidars or cameras");
  }
  return rig;
}

void WriteRigFile(const std::filesystem::path& path, const Rig& rig) {
  std::string text = "# MLIC rig file: how the sensors are arranged and where their data are.\n";
  text += "format: " + kRigFormat.Text() + "\n";
  text += "imu:\n  topic: " + Scalar(rig.imu.topic) + "\n";
  if (!rig.imu.frame_id.empty()) text += "  frame_id: " + Scalar(rig.imu.frame_id) + "\n";
  if (rig.imu.noise) {
    text += "  noise: {gyroscope: " + ShortNumber(rig.imu.noise->gyroscope, 12) +
            ", accelerometer: " + ShortNumber(rig.imu.noise->accelerometer, 12) + "}\n";
  }
  text += "  intrinsics: " + ImuIntrinsicsNames()[static_cast<std::size_t>(rig.imu.intrinsics)] + "\n";
  if (rig.imu.alignment_sigma != ImuConfig().alignment_sigma) {
    text += "  alignment_sigma_deg: " + ShortNumber(rig.imu.alignment_sigma * kDegreesPerRadian, 12) + "\n";
  }
  if (rig.imu.gravity) text += "  gravity: " + ShortNumber(*rig.imu.gravity, 12) + "\n";
  if (!rig.lidars.empty()) text += "lidars:\n";
  for (const LidarConfig& lidar : rig.lidars) text += SensorText(lidar);
  if (!rig.cameras.empty()) text += "cameras:\n";
  for (const CameraConfig& camera : rig.cameras) text += CameraText(camera);
  WriteFileAtomically(path, text);
}

}  // namespace mlic
