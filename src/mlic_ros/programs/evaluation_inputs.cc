#include "mlic_ros/programs/evaluation_inputs.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "mlic_core/common/error.h"
#include "mlic_core/io/result/trajectory_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/bag/rig_draft.h"

namespace mlic {
namespace {

// configs: the bag's LiDARs or cameras; kind: "LiDAR" or "camera".
template <typename Config>
const Config& TopicOf(const BagSet& bags, const std::vector<Config>& configs, const std::string& kind,
                      const SensorResult& sensor) {
  std::vector<const Config*> of_frame, of_name;
  std::string list;
  for (const Config& config : configs) {
    if (!sensor.frame_id.empty() && config.frame_id == sensor.frame_id) of_frame.push_back(&config);
    if (config.name == sensor.name) of_name.push_back(&config);
    list += (list.empty() ? "" : ", ") + config.topic + " (" + config.frame_id + ")";
  }
  if (of_frame.size() == 1) return *of_frame.front();
  if (of_name.size() == 1) return *of_name.front();
  throw InputError("bag " + bags.names() + ": " + std::to_string(of_frame.size()) + " " + kind +
                   " topics have the frame " + sensor.frame_id + " of " + sensor.name +
                   ", expected one; give the bag's rig file by --rig. " + kind + " topics (frames): " + list);
}

}  // namespace

std::vector<StampedPose> ReadTrajectoryBeside(const std::filesystem::path& calibration) {
  const std::filesystem::path path = calibration.parent_path() / "trajectory.tum";
  if (!std::filesystem::exists(path)) {
    throw InputError(
        path.string() +
        ": no such file; evaluate needs the trajectory that calibrate writes beside calibration.yaml");
  }
  const std::vector<StampedPose> trajectory = ReadTrajectoryFile(path);
  const auto ends = std::adjacent_find(trajectory.begin(), trajectory.end(),
                                       [](const auto& a, const auto& b) { return a.time >= b.time; });
  if (trajectory.size() < 2 || ends != trajectory.end()) {
    throw InputError(path.string() + ": expected at least two poses in order of time; run calibrate again");
  }
  return trajectory;
}

std::vector<CameraKeyframes> ReadKeyframesBeside(const std::filesystem::path& calibration) {
  const std::filesystem::path path = calibration.parent_path() / "images" / "keyframes.csv";
  std::vector<CameraKeyframes> keyframes;
  if (!std::filesystem::exists(path)) return keyframes;
  std::istringstream text(ReadFile(path));
  std::string line;
  std::getline(text, line);  // the titles
  while (std::getline(text, line)) {
    const std::size_t comma = line.rfind(',');
    const std::string camera = line.substr(0, comma);
    char* end = nullptr;
    const TimeNs stamp = comma == std::string::npos ? 0 : std::strtoll(&line[comma + 1], &end, 10);
    if (end == nullptr || *end != '\0') {
      throw InputError(path.string() + ": expected camera,stamp_ns but found '" + line +
                       "'; run calibrate again");
    }
    if (keyframes.empty() || keyframes.back().camera != camera) keyframes.push_back({camera, {}});
    keyframes.back().stamps.push_back(stamp);
  }
  return keyframes;
}

Rig RigOfCalibration(const BagSet& bags, const CalibrationResult& calibration) {
  std::vector<std::string> notes;
  const Rig draft = DraftRig(bags, notes);
  Rig rig;
  rig.imu = draft.imu;
  for (const SensorResult& sensor : calibration.sensors) {
    if (sensor.type == SensorResult::Type::kLidar) {
      rig.lidars.push_back(TopicOf(bags, draft.lidars, "LiDAR", sensor));
      rig.lidars.back().name = sensor.name;
    } else {
      rig.cameras.push_back(TopicOf(bags, draft.cameras, "camera", sensor));
      rig.cameras.back().name = sensor.name;
    }
  }
  return rig;
}

CalibrationResult WithPosesOf(const CalibrationResult& calibration, const CalibrationResult& other) {
  CalibrationResult moved = calibration;
  moved.sensors.clear();
  for (SensorResult sensor : calibration.sensors) {
    const auto found = std::find_if(other.sensors.begin(), other.sensors.end(),
                                    [&](const SensorResult& s) { return s.name == sensor.name; });
    if (found == other.sensors.end()) continue;
    sensor.calibration = found->calibration;
    sensor.intrinsics = found->intrinsics;
    sensor.rolling_shutter_readout = found->rolling_shutter_readout;
    moved.sensors.push_back(sensor);
  }
  return moved;
}

CalibrationResult AtGuesses(const CalibrationResult& calibration, const Rig& rig) {
  CalibrationResult moved = calibration;
  moved.sensors.clear();
  for (const LidarConfig& lidar : rig.lidars) {
    const auto found = std::find_if(calibration.sensors.begin(), calibration.sensors.end(),
                                    [&](const SensorResult& sensor) { return sensor.name == lidar.name; });
    if (found == calibration.sensors.end() || !lidar.guess) continue;
    moved.sensors.push_back(*found);
    moved.sensors.back().calibration.T_imu_sensor = lidar.guess->T_imu_sensor;
  }
  return moved;
}

}  // namespace mlic
