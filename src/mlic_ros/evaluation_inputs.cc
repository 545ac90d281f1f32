#include "mlic_ros/evaluation_inputs.h"

#include <algorithm>

#include "mlic_core/common/error.h"
#include "mlic_core/io/trajectory_file.h"
#include "mlic_ros/rig_draft.h"

namespace mlic {
namespace {

const LidarConfig& TopicOf(const BagSet& bags, const Rig& draft, const SensorResult& sensor) {
  std::vector<const LidarConfig*> of_frame, of_name;
  std::string list;
  for (const LidarConfig& lidar : draft.lidars) {
    if (!sensor.frame_id.empty() && lidar.frame_id == sensor.frame_id) of_frame.push_back(&lidar);
    if (lidar.name == sensor.name) of_name.push_back(&lidar);
    list += (list.empty() ? "" : ", ") + lidar.topic + " (" + lidar.frame_id + ")";
  }
  if (of_frame.size() == 1) return *of_frame.front();
  if (of_name.size() == 1) return *of_name.front();
  throw InputError("bag " + bags.names() + ": " + std::to_string(of_frame.size()) +
                   " LiDAR topics have the frame " + sensor.frame_id + " of " + sensor.name +
                   ", expected one; give the bag's rig file by --rig. LiDAR topics (frames): " + list);
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

Rig RigOfCalibration(const BagSet& bags, const CalibrationResult& calibration) {
  std::vector<std::string> notes;
  const Rig draft = DraftRig(bags, notes);
  Rig rig;
  rig.imu = draft.imu;
  for (const SensorResult& sensor : calibration.sensors) {
    if (sensor.type != SensorResult::Type::kLidar) continue;
    LidarConfig lidar = TopicOf(bags, draft, sensor);
    lidar.name = sensor.name;
    rig.lidars.push_back(lidar);
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
    moved.sensors.push_back(sensor);
  }
  return moved;
}

}  // namespace mlic
