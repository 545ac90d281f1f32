#include "mlic_core/io/rig/rig_parsing.h"

#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

// A sensor farther from the IMU than this is a file in millimetres, not a vehicle.
constexpr double kLargestLeverArm = 100.0;  // from: guard

void CheckName(const YamlReader& sensor) {
  const std::string& name = sensor.Name();
  bool good = !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0;
  for (const char c : name) good = good && (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_');
  if (!good) sensor.Fail("a sensor's name is made of letters, digits and _ and starts with a letter");
}

RigidTransform ParsePose(const YamlReader& pose) {
  pose.CheckKeys({"xyz", "rpy_deg", "rotation"});
  RigidTransform T_imu_sensor;
  const YamlReader xyz = pose.Get("xyz", "give xyz: [x, y, z] in metres");
  T_imu_sensor.translation = xyz.Vector3("x, y, z in metres");
  if (T_imu_sensor.translation.norm() > kLargestLeverArm) {
    xyz.Fail("more than 100 m from the IMU; metres are expected");
  }
  if (pose.Has("rpy_deg") == pose.Has("rotation")) {
    pose.Fail("give exactly one of rpy_deg: [roll, pitch, yaw] and rotation: [x, y, z, w]");
  }
  if (pose.Has("rotation")) {
    T_imu_sensor.rotation = ParseQuaternion(pose.Get("rotation"));
    return T_imu_sensor;
  }
  const YamlReader angles = pose.Get("rpy_deg");
  const Eigen::Vector3d rpy = angles.Vector3("roll, pitch, yaw in degrees");
  if (rpy.cwiseAbs().maxCoeff() > 360.0) angles.Fail("angles are in degrees, between -360 and 360");
  T_imu_sensor.rotation = FromRollPitchYaw(rpy * kRadiansPerDegree);
  return T_imu_sensor;
}

Eigen::Vector3d ParseSigma(const YamlReader& sigma, const std::string& meaning) {
  const Eigen::Vector3d values = sigma.Vector3(meaning);
  if (values.minCoeff() <= 0.0) {
    sigma.Fail(
        "a standard deviation must be positive; for a sensor that is known exactly use fixed: true without "
        "it");
  }
  return values;
}

std::optional<ExtrinsicGuess> ParseGuess(const YamlReader& sensor) {
  if (!sensor.Has("T_imu_sensor")) {
    if (sensor.Has("sigma")) sensor.Get("sigma").Fail("sigma belongs to a guess; give T_imu_sensor too");
    return std::nullopt;
  }
  ExtrinsicGuess guess;
  guess.T_imu_sensor = ParsePose(sensor.Get("T_imu_sensor"));
  if (sensor.Has("sigma")) {
    const YamlReader sigma = sensor.Get("sigma");
    sigma.CheckKeys({"xyz", "rpy_deg"});
    if (sigma.Has("xyz")) guess.sigma_translation = ParseSigma(sigma.Get("xyz"), "in metres");
    if (sigma.Has("rpy_deg")) {
      guess.sigma_rotation = kRadiansPerDegree * ParseSigma(sigma.Get("rpy_deg"), "in degrees");
    }
  }
  return guess;
}

// That of a fixed sensor, where the file gives one: what it leaves out is exact.
std::optional<HeldSigma> ParseHeldSigma(const YamlReader& sensor, const ExtrinsicGuess& guess) {
  if (!sensor.Has("sigma")) return std::nullopt;
  HeldSigma held;
  if (sensor.Get("sigma").Has("xyz")) held.translation = guess.sigma_translation;
  if (sensor.Get("sigma").Has("rpy_deg")) held.rotation = guess.sigma_rotation;
  return held;
}

// What LiDARs and cameras have in common.
template <typename Config>
void ParseSensor(const YamlReader& sensor, Config* config, bool* enabled) {
  CheckName(sensor);
  config->name = sensor.Name();
  *enabled = !sensor.Has("enabled") || sensor.Get("enabled").Flag();
  config->topic = sensor.Get("topic", "give the topic in the bag (inspect_bag lists them)").String();
  if (sensor.Has("frame_id")) config->frame_id = sensor.Get("frame_id").String();
  config->guess = ParseGuess(sensor);
  if (sensor.Has("time_offset")) {
    const YamlReader offset = sensor.Get("time_offset");
    config->time_offset = offset.Number();
    if (std::abs(*config->time_offset) > 10.0) offset.Fail("more than 10 s; seconds are expected");
  }
  config->fixed = sensor.Has("fixed") && sensor.Get("fixed").Flag();
  if (config->fixed && !config->guess) {
    sensor.Get("fixed").Fail("a fixed sensor stays at its T_imu_sensor; give T_imu_sensor too");
  }
  if (config->fixed) config->held_sigma = ParseHeldSigma(sensor, *config->guess);
}

std::vector<double> ParseCameraIntrinsics(const YamlReader& intrinsics, CameraModel model) {
  const std::string name = CameraModelNames()[static_cast<std::size_t>(model)];
  const std::vector<double> values =
      intrinsics.Numbers(4 + DistortionCount(model), "(fx fy cx cy and the distortion of " + name + ")");
  if (values[0] <= 0.0 || values[1] <= 0.0) intrinsics.Fail("fx and fy must be positive, in pixels");
  return values;
}

}  // namespace

const std::vector<std::string>& CameraModelNames() {
  static const std::vector<std::string> names{"plumb_bob", "rational_polynomial", "equidistant",
                                              "double_sphere"};
  return names;
}

const std::vector<std::string>& ShutterNames() {
  static const std::vector<std::string> names{"global", "rolling"};
  return names;
}

const std::vector<std::string>& ImuIntrinsicsNames() {
  static const std::vector<std::string> names{"bias", "scale_misalignment"};
  return names;
}

std::size_t DistortionCount(CameraModel model) {
  switch (model) {
    case CameraModel::kPlumbBob:
      return 5;
    case CameraModel::kRationalPolynomial:
      return 8;
    case CameraModel::kEquidistant:
      return 4;
    case CameraModel::kDoubleSphere:
      return 2;
  }
  return 0;
}

Eigen::Quaterniond ParseQuaternion(const YamlReader& rotation) {
  const std::vector<double> xyzw = rotation.Numbers(4, "x, y, z, w of a unit quaternion");
  const Eigen::Quaterniond q(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  if (std::abs(q.norm() - 1.0) > 0.01)
    rotation.Fail("not a unit quaternion (x, y, z, w); its length must be 1");
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  return Eigen::Quaterniond(sign * q.coeffs()).normalized();
}

ImuConfig ParseImu(const YamlReader& imu) {
  imu.CheckKeys({"topic", "frame_id", "noise", "intrinsics", "alignment_sigma_deg", "gravity"});
  ImuConfig config;
  config.topic = imu.Get("topic", "give the IMU's topic in the bag (inspect_bag lists them)").String();
  if (imu.Has("frame_id")) config.frame_id = imu.Get("frame_id").String();
  if (imu.Has("noise")) {
    const YamlReader noise = imu.Get("noise");
    noise.CheckKeys({"gyroscope", "accelerometer"});
    const YamlReader gyroscope = noise.Get("gyroscope", "give its noise density in rad/s/sqrt(Hz)");
    const YamlReader accelerometer = noise.Get("accelerometer", "give its noise density in m/s^2/sqrt(Hz)");
    config.noise = ImuNoise{gyroscope.Number(), accelerometer.Number()};
    if (config.noise->gyroscope <= 0.0) gyroscope.Fail("a noise density must be positive");
    if (config.noise->accelerometer <= 0.0) accelerometer.Fail("a noise density must be positive");
  }
  if (imu.Has("intrinsics")) {
    config.intrinsics = static_cast<ImuIntrinsicsModel>(imu.Get("intrinsics").Choice(ImuIntrinsicsNames()));
  }
  if (imu.Has("alignment_sigma_deg")) {
    const YamlReader sigma = imu.Get("alignment_sigma_deg");
    config.alignment_sigma = kRadiansPerDegree * sigma.Number();
    if (config.alignment_sigma <= 0.0 || config.alignment_sigma > 0.5 * M_PI) {
      sigma.Fail("of the accelerometer's axes to the gyroscope's, degrees: above 0 and at most 90");
    }
  }
  if (imu.Has("gravity")) {
    config.gravity = imu.Get("gravity").Number();
    if (*config.gravity < 9.7 || *config.gravity > 9.9) {
      imu.Get("gravity").Fail("the magnitude of gravity in m/s^2, from 9.76 to 9.84 on the ground");
    }
  }
  return config;
}

LidarConfig ParseLidar(const YamlReader& lidar, bool* enabled) {
  lidar.CheckKeys({"topic", "frame_id", "T_imu_sensor", "sigma", "time_offset", "fixed", "enabled"});
  LidarConfig config;
  ParseSensor(lidar, &config, enabled);
  return config;
}

CameraConfig ParseCamera(const YamlReader& camera, bool* enabled) {
  camera.CheckKeys({"topic", "frame_id", "model", "fov_deg", "intrinsics", "intrinsics_fixed", "shutter",
                    "mask", "T_imu_sensor", "sigma", "time_offset", "fixed", "enabled"});
  CameraConfig config;
  ParseSensor(camera, &config, enabled);
  if (camera.Has("model"))
    config.model = static_cast<CameraModel>(camera.Get("model").Choice(CameraModelNames()));
  if (camera.Has("fov_deg")) {
    config.fov_deg = camera.Get("fov_deg").Number();
    if (*config.fov_deg <= 0.0 || *config.fov_deg > 360.0) {
      camera.Get("fov_deg").Fail("the horizontal field of view is in degrees, above 0 and at most 360");
    }
  }
  if (camera.Has("intrinsics")) {
    config.intrinsics = ParseCameraIntrinsics(camera.Get("intrinsics"), config.model);
  }
  config.intrinsics_fixed = camera.Has("intrinsics_fixed") && camera.Get("intrinsics_fixed").Flag();
  if (config.intrinsics_fixed && !config.intrinsics) {
    camera.Get("intrinsics_fixed").Fail("fixed intrinsics stay as they are given; give intrinsics too");
  }
  if (camera.Has("shutter"))
    config.shutter = static_cast<Shutter>(camera.Get("shutter").Choice(ShutterNames()));
  if (camera.Has("mask")) config.mask = camera.Get("mask").String();
  return config;
}

}  // namespace mlic
