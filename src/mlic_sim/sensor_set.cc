#include "mlic_sim/sensor_set.h"

#include <cmath>
#include <map>

#include "mlic_core/common/angles.h"
#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/yaml_section.h"

namespace mlic::sim {
namespace {

Eigen::Quaterniond FromDegrees(const double rpy_deg[3]) {
  return FromRollPitchYaw(kRadiansPerDegree * Eigen::Vector3d(rpy_deg[0], rpy_deg[1], rpy_deg[2]));
}

void ReadTransform(const Section& parent, const std::string& key, RigidTransform& T) {
  if (!parent.Has(key)) return;
  const Section section = parent.Sub(key);
  section.OnlyKeys({"xyz", "rpy_deg"});
  double rpy_deg[3] = {0, 0, 0};
  section.ReadNumbers("xyz", T.translation.data(), 3);
  section.ReadNumbers("rpy_deg", rpy_deg, 3);
  T.rotation = FromDegrees(rpy_deg);
}

void ReadMatrix(const Section& section, const std::string& key, Eigen::Matrix3d& matrix) {
  Eigen::Matrix3d transposed = matrix.transpose();  // the file goes row by row, Eigen column by column
  section.ReadNumbers(key, transposed.data(), 9);
  matrix = transposed.transpose();
}

void ReadFilterAndSurroundings(const Section& s, SimulatedImu* imu) {
  s.Read("gravity", imu->gravity);
  if (s.Has("low_pass")) {
    const Section low_pass = s.Sub("low_pass");
    low_pass.OnlyKeys({"gyroscope", "accelerometer"});
    low_pass.Read("gyroscope", imu->gyroscope_low_pass);
    low_pass.Read("accelerometer", imu->accelerometer_low_pass);
    for (const double share : {imu->gyroscope_low_pass, imu->accelerometer_low_pass}) {
      if (share < 0.0 || share > 0.5)
        s.Fail(s.Need("low_pass"), "a cut-off is a share of the rate, up to 0.5");
    }
  }
  if (s.Has("stamps")) {
    const Section stamps = s.Sub("stamps");
    stamps.OnlyKeys({"jitter", "step", "doubled"});
    stamps.Read("jitter", imu->stamp_jitter);
    stamps.Read("step", imu->stamp_step);
    stamps.Read("doubled", imu->doubled);
  }
  if (s.Has("warm_up")) {
    const Section warm_up = s.Sub("warm_up");
    warm_up.OnlyKeys({"gyroscope", "accelerometer", "time_constant"});
    warm_up.ReadNumbers("gyroscope", imu->warm_up.gyroscope.data(), 3);
    warm_up.ReadNumbers("accelerometer", imu->warm_up.accelerometer.data(), 3);
    warm_up.ReadPositive("time_constant", imu->warm_up.time_constant);
  }
  if (!s.Has("vibration")) return;
  if (!s.Need("vibration").IsSequence()) s.Fail(s.Need("vibration"), "'vibration' must be a list");
  for (const YAML::Node& node : s.Need("vibration")) {
    const Section line = s.Element("vibration", node);
    line.OnlyKeys({"frequency", "specific_force", "angular_velocity"});
    imu->vibration.emplace_back();
    line.ReadPositive("frequency", imu->vibration.back().frequency);
    line.Read("specific_force", imu->vibration.back().specific_force);
    line.Read("angular_velocity", imu->vibration.back().angular_velocity);
  }
}

SimulatedImu ReadImu(const Section& s) {
  s.OnlyKeys({"topic", "frame_id", "rate", "T_body_imu", "noise", "gyroscope_bias", "accelerometer_bias",
              "gyroscope_matrix", "accelerometer_matrix", "intrinsics", "low_pass", "vibration", "gravity",
              "stamps", "warm_up"});
  SimulatedImu imu;
  s.Read("topic", imu.topic);
  s.Read("frame_id", imu.frame_id);
  s.ReadPositive("rate", imu.rate);
  ReadTransform(s, "T_body_imu", imu.T_body_imu);
  if (s.Has("noise")) {
    const Section noise = s.Sub("noise");
    noise.OnlyKeys({"gyroscope", "accelerometer", "gyroscope_walk", "accelerometer_walk"});
    noise.Read("gyroscope", imu.noise.gyroscope);
    noise.Read("accelerometer", imu.noise.accelerometer);
    noise.Read("gyroscope_walk", imu.gyroscope_walk);
    noise.Read("accelerometer_walk", imu.accelerometer_walk);
  }
  s.ReadNumbers("gyroscope_bias", imu.calibration.gyroscope_bias.data(), 3);
  s.ReadNumbers("accelerometer_bias", imu.calibration.accelerometer_bias.data(), 3);
  ReadMatrix(s, "gyroscope_matrix", imu.calibration.gyroscope_matrix);
  ReadMatrix(s, "accelerometer_matrix", imu.calibration.accelerometer_matrix);
  s.ReadName<ImuIntrinsicsModel>(
      "intrinsics",
      {{"bias", ImuIntrinsicsModel::kBias}, {"scale_misalignment", ImuIntrinsicsModel::kScaleMisalignment}},
      imu.intrinsics);
  ReadFilterAndSurroundings(s, &imu);
  return imu;
}

void ReadPattern(const Section& lidar, LidarModel& m) {
  const Section s = lidar.Sub("pattern");
  s.Need("kind");
  s.ReadName<ScanPatternKind>("kind",
                              {{"spinning", ScanPatternKind::kSpinning},
                               {"raster", ScanPatternKind::kRaster},
                               {"rosette", ScanPatternKind::kRosette}},
                              m.kind);
  switch (m.kind) {
    case ScanPatternKind::kSpinning:
      s.OnlyKeys({"kind", "rpy_deg", "rings", "vertical_fov_deg", "azimuth_steps", "clockwise",
                  "simultaneous_rings"});
      break;
    case ScanPatternKind::kRaster:
      s.OnlyKeys({"kind", "rpy_deg", "fov_deg", "columns", "rows"});
      break;
    case ScanPatternKind::kRosette:
      s.OnlyKeys({"kind", "rpy_deg", "cone_fov_deg", "points_per_scan", "prism_rates_hz"});
      break;
  }
  s.Read("rings", m.rings);
  s.ReadNumbers("vertical_fov_deg", m.vertical_fov_deg, 2);
  s.Read("azimuth_steps", m.azimuth_steps);
  s.Read("clockwise", m.clockwise);
  s.Read("simultaneous_rings", m.simultaneous_rings);
  s.ReadNumbers("fov_deg", m.fov_deg, 2);
  s.Read("columns", m.columns);
  s.Read("rows", m.rows);
  s.Read("cone_fov_deg", m.cone_fov_deg);
  s.Read("points_per_scan", m.points_per_scan);
  s.ReadNumbers("prism_rates_hz", m.prism_rates_hz, 2);
  if (m.rings < 1 || m.rings > 1024 || m.azimuth_steps < 1 || m.columns < 1 || m.rows < 1 ||
      m.points_per_scan < 1) {
    s.Fail(s.node(), "counts of rings, steps, columns, rows and points must be positive");
  }
  double rpy_deg[3] = {0, 0, 0};
  s.ReadNumbers("rpy_deg", rpy_deg, 3);
  m.R_sensor_pattern = FromDegrees(rpy_deg);
}

// What LiDARs and cameras have in common.
template <typename Sensor>
Sensor ReadPlacement(const std::string& name, const char* topic, const Section& s) {
  Sensor sensor;
  sensor.name = name;
  sensor.topic = "/" + name + topic;
  sensor.frame_id = name;
  s.Read("topic", sensor.topic);
  s.Read("frame_id", sensor.frame_id);
  s.Need("T_imu_sensor");
  ReadTransform(s, "T_imu_sensor", sensor.calibration.T_imu_sensor);
  s.Read("time_offset", sensor.calibration.time_offset);
  if (s.Has("clock_drift_ppm")) {
    double ppm = 0.0;
    s.Read("clock_drift_ppm", ppm);
    if (std::abs(ppm) > 1e4) s.Fail(s.Need("clock_drift_ppm"), "at most 10000 ppm, which is 1 percent");
    sensor.calibration.clock_drift = 1e-6 * ppm;
  }
  return sensor;
}

SimulatedLidar ReadLidar(const std::string& name, const Section& s) {
  s.OnlyKeys({"topic",
              "frame_id",
              "T_imu_sensor",
              "time_offset",
              "layout",
              "stamp",
              "phase",
              "rate",
              "pattern",
              "min_range",
              "max_range",
              "range_noise",
              "beam_divergence_deg",
              "range_at_10_percent",
              "random_dropouts",
              "ring_bias",
              "range_walk",
              "packet_loss",
              "rain",
              "clock_drift_ppm"});
  auto lidar = ReadPlacement<SimulatedLidar>(name, "/points", s);
  s.ReadName<PointLayout>("layout",
                          {{"velodyne", PointLayout::kVelodyne},
                           {"ouster", PointLayout::kOuster},
                           {"hesai", PointLayout::kHesai},
                           {"robosense", PointLayout::kRobosense},
                           {"livox", PointLayout::kLivox},
                           {"none", PointLayout::kNoTime}},
                          lidar.layout);
  s.ReadName<bool>("stamp", {{"start", false}, {"end", true}}, lidar.stamp_at_end);
  if (lidar.stamp_at_end && (lidar.layout == PointLayout::kOuster || lidar.layout == PointLayout::kLivox)) {
    s.Fail(s.Need("stamp"), "'stamp: end' needs a layout with signed or absolute point times");
  }
  LidarModel& m = lidar.model;
  s.Read("phase", lidar.phase);
  s.ReadPositive("rate", m.rate);
  ReadPattern(s, m);
  if (lidar.layout == PointLayout::kOuster && m.kind != ScanPatternKind::kSpinning) {
    s.Fail(s.Need("layout"), "'layout: ouster' is organised by rings: it needs a spinning pattern");
  }
  s.Read("min_range", m.min_range);
  s.ReadPositive("max_range", m.max_range);
  s.Read("range_noise", m.range_noise);
  s.Read("beam_divergence_deg", m.beam_divergence_deg);
  s.ReadPositive("range_at_10_percent", m.range_at_10_percent);
  s.Read("random_dropouts", m.random_dropouts);
  s.Read("ring_bias", m.ring_bias);
  const auto rings = static_cast<std::size_t>(m.kind == ScanPatternKind::kSpinning ? m.rings
                                              : m.kind == ScanPatternKind::kRaster ? m.rows
                                                                                   : 1);
  if (!m.ring_bias.empty() && m.ring_bias.size() != rings) {
    s.Fail(s.Need("ring_bias"), "'ring_bias' must have a number for each of the " + std::to_string(rings) +
                                    " rings (raster: rows)");
  }
  s.Read("range_walk", m.range_walk);
  s.Read("packet_loss", m.packet_loss);
  s.Read("rain", m.rain);
  if (m.packet_loss < 0.0 || m.packet_loss > 1.0 || m.rain < 0.0) {
    s.Fail(s.node(), "'packet_loss' must be a share from 0 to 1, 'rain' (1/m) not negative");
  }
  return lidar;
}

void ReadIntrinsics(const Section& s, CameraIntrinsics& intrinsics) {
  s.ReadName<CameraModel>("model",
                          {{"plumb_bob", CameraModel::kPlumbBob},
                           {"rational_polynomial", CameraModel::kRationalPolynomial},
                           {"equidistant", CameraModel::kEquidistant},
                           {"double_sphere", CameraModel::kDoubleSphere}},
                          intrinsics.model);
  double size[2] = {0, 0};
  s.Need("image_size");
  s.ReadNumbers("image_size", size, 2);
  intrinsics.width = static_cast<int>(size[0]), intrinsics.height = static_cast<int>(size[1]);
  if (intrinsics.width < 16 || intrinsics.height < 16 || intrinsics.width > 8192 ||
      intrinsics.height > 8192) {
    s.Fail(s.Need("image_size"), "'image_size' must be [width, height], each from 16 to 8192 pixels");
  }
  intrinsics.parameters.resize(static_cast<std::size_t>(ParameterCount(intrinsics.model)));
  s.Need("intrinsics");
  s.ReadNumbers("intrinsics", intrinsics.parameters.data(), intrinsics.parameters.size());
  if (!(intrinsics.parameters[0] > 0.0) || !(intrinsics.parameters[1] > 0.0)) {
    s.Fail(s.Need("intrinsics"), "the focal lengths, the first two of 'intrinsics', must be positive");
  }
}

void ReadImage(const Section& s, SimulatedCamera& camera) {
  s.ReadName<bool>("shutter", {{"global", false}, {"rolling", true}}, camera.rolling_shutter);
  s.Read("readout", camera.readout);
  if (camera.rolling_shutter != (camera.readout > 0.0)) {
    s.Fail(s.node(), "'readout' (s) must be positive with 'shutter: rolling', and left out otherwise");
  }
  s.ReadName<ImageEncoding>("encoding",
                            {{"mono8", ImageEncoding::kMono8},
                             {"bgr8", ImageEncoding::kBgr8},
                             {"bayer_rggb8", ImageEncoding::kBayerRggb8},
                             {"jpeg", ImageEncoding::kJpeg},
                             {"mono_jpeg", ImageEncoding::kMonoJpeg}},
                            camera.encoding);
  s.ReadName<CameraInfoContent>("camera_info",
                                {{"none", CameraInfoContent::kNone},
                                 {"empty", CameraInfoContent::kEmpty},
                                 {"true", CameraInfoContent::kTrue}},
                                camera.camera_info);
  s.Read("exposure", camera.exposure);
  s.Read("shortest_exposure", camera.shortest_exposure);
  s.Read("jpeg_quality", camera.jpeg_quality);
  s.ReadPositive("gain", camera.gain);
  s.Read("exposure_drift", camera.exposure_drift);
  s.Read("vignetting", camera.vignetting);
  s.ReadPositive("full_well", camera.full_well);
  s.Read("read_noise", camera.read_noise);
  if (camera.exposure < 0.0 || camera.exposure > 1.0 / camera.rate) {
    s.Fail(s.Need("exposure"), "'exposure' (s) must be between 0 and the time between two images");
  }
  if (camera.shortest_exposure < 0.0 || camera.shortest_exposure > camera.exposure) {
    s.Fail(s.Need("shortest_exposure"), "'shortest_exposure' (s) must be between 0 and 'exposure'");
  }
  if (camera.jpeg_quality < 1 || camera.jpeg_quality > 100) {
    s.Fail(s.Need("jpeg_quality"), "'jpeg_quality' must be from 1 to 100");
  }
}

SimulatedCamera ReadCamera(const std::string& name, const Section& s) {
  s.OnlyKeys({"topic",
              "frame_id",
              "T_imu_sensor",
              "time_offset",
              "rate",
              "phase",
              "model",
              "image_size",
              "intrinsics",
              "fov_deg",
              "shutter",
              "readout",
              "exposure",
              "encoding",
              "camera_info",
              "jpeg_quality",
              "gain",
              "exposure_drift",
              "vignetting",
              "full_well",
              "read_noise",
              "clock_drift_ppm",
              "shortest_exposure"});
  auto camera = ReadPlacement<SimulatedCamera>(name, "/image_raw", s);
  s.ReadPositive("rate", camera.rate);
  s.Read("phase", camera.phase);
  ReadIntrinsics(s, camera.intrinsics);
  s.Need("fov_deg");
  s.ReadPositive("fov_deg", camera.fov_deg);
  ReadImage(s, camera);
  return camera;
}

}  // namespace

SensorSet LoadSensorSet(const std::filesystem::path& path) {
  YAML::Node file;
  try {
    file = YAML::LoadFile(path.string());
  } catch (const YAML::BadFile&) {
    throw InputError(path.string() +
                     ": cannot be opened; give the path of a sensors file (config/simulation has some)");
  } catch (const YAML::ParserException& error) {
    throw InputError(path.string() + ":" + std::to_string(error.mark.line + 1) +
                     ": not valid YAML: " + error.msg);
  }
  const Section root(path.string(), "file", file);
  root.OnlyKeys({"imu", "lidars", "cameras", "world"});
  SensorSet set;
  if (root.Has("world")) {
    const Section world = Section(path.string(), "world", root.Need("world"));
    world.OnlyKeys({"infrared"});
    world.ReadName("infrared",
                   {{"related", InfraredLook::kRelated}, {"inverted_half", InfraredLook::kInvertedHalf}},
                   set.infrared);
  }
  set.imu = ReadImu(Section(path.string(), "imu", root.Need("imu")));
  std::map<std::string, std::string> name_of_topic;
  const auto read_all = [&](const std::string& kind, const auto& read, auto& sensors) {
    if (!root.Has(kind)) return;
    const Section section(path.string(), kind, root.Need(kind));
    for (const auto& entry : section.node()) {
      const std::string name = entry.first.template as<std::string>();
      sensors.push_back(read(name, Section(path.string(), kind + "." + name, entry.second)));
      const auto [other, is_new] = name_of_topic.emplace(sensors.back().topic, name);
      if (!is_new) root.Fail(entry.second, "'" + name + "' has the topic of '" + other->second + "'");
    }
  };
  read_all("lidars", ReadLidar, set.lidars);
  read_all("cameras", ReadCamera, set.cameras);
  if (set.lidars.empty() && set.cameras.empty()) {
    root.Fail(file, "no sensor: at least one is needed under 'lidars' or 'cameras'");
  }
  return set;
}

}  // namespace mlic::sim
