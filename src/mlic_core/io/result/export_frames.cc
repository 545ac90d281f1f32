#include "mlic_core/io/result/export_frames.h"

#include <algorithm>
#include <set>

namespace mlic {
namespace {

std::string WithoutLeadingSlash(const std::string& frame) {
  return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame;
}

// xacro and roslaunch substitute what follows a $, and neither has an escape for it that
// robot_state_publisher and check_urdf would read as well; ROS takes an argument with := for a remapping;
// control characters and bytes beyond ASCII do not get through XML and the locale of every node.
bool CanBeWritten(const std::string& frame) {
  return frame.find(":=") == std::string::npos &&
         std::all_of(frame.begin(), frame.end(), [](char c) { return c >= ' ' && c <= '~' && c != '$'; });
}

// The frame, or the other name with a note.
std::string Writable(const std::string& frame, const std::string& owner, const std::string& other,
                     std::vector<std::string>* notes) {
  if (CanBeWritten(frame)) return frame;
  std::string shown;
  for (const char c : frame) shown += c >= ' ' && c <= '~' ? c : '?';
  notes->push_back(owner + ": its frame '" + shown +
                   "' cannot stand in launch and URDF files (only printable ASCII without $ and := can); "
                   "they call it " +
                   other + ", give another as frame_id in the rig file");
  return other;
}

// Empty where it is not known.
std::string FrameOfRejected(const CalibrationResult& result, const std::string& sensor) {
  for (const RejectedSensor& rejected : result.rejected) {
    if (rejected.name == sensor) return rejected.frame_id;
  }
  return "";
}

}  // namespace

std::vector<ExportedSensor> ExportedSensors(const CalibrationResult& result) {
  std::vector<ExportedSensor> exported;
  if (result.root.empty()) {
    for (const SensorResult& sensor : result.sensors) {
      exported.push_back({sensor.name, sensor.frame_id, sensor.calibration.T_imu_sensor});
    }
  }
  for (const PairResult& pair : result.pairs) {
    if (result.root.empty()) break;
    if (pair.a == result.root) exported.push_back({pair.b, FrameOfRejected(result, pair.b), pair.T_a_b});
    if (pair.b == result.root) {
      exported.push_back({pair.a, FrameOfRejected(result, pair.a), pair.T_a_b.Inverse()});
    }
  }
  return exported;
}

ExportFrames FramesOf(const CalibrationResult& result) {
  ExportFrames frames;
  const bool imu = result.root.empty();
  const std::string name = imu ? "imu" : result.root;
  frames.root =
      Writable(WithoutLeadingSlash(imu ? result.imu_frame_id : FrameOfRejected(result, result.root)),
               imu ? "the IMU" : name, name, &frames.notes);
  if (frames.root.empty()) frames.root = name;
  std::set<std::string> used{frames.root};
  for (const ExportedSensor& sensor : ExportedSensors(result)) {
    std::string frame =
        Writable(WithoutLeadingSlash(sensor.frame_id), sensor.name, sensor.name, &frames.notes);
    if (frame.empty() || used.count(frame) > 0) frame = sensor.name;
    while (!used.insert(frame).second) frame += "_frame";
    frames.sensors.push_back(frame);
  }
  return frames;
}

std::string EscapeXml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

}  // namespace mlic
