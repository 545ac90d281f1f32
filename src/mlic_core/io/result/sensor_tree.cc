#include "mlic_core/io/result/sensor_tree.h"

#include <algorithm>

#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

std::optional<double> TimeOffsetOf(const CalibrationResult& result, const std::string& sensor) {
  for (const SensorResult& candidate : result.sensors) {
    if (candidate.name == sensor) return candidate.calibration.time_offset;
  }
  return std::nullopt;
}

std::string NameOfRoot(const CalibrationResult& result) { return result.root.empty() ? "imu" : result.root; }

}  // namespace

SensorTree TreeOf(const CalibrationResult& result) {
  const ExportFrames frames = FramesOf(result);
  const std::vector<ExportedSensor> sensors = ExportedSensors(result);
  SensorTree tree{frames.root, {}};
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    tree.frames.push_back({sensors[i].name, frames.sensors[i], sensors[i].T_root_sensor,
                           TimeOffsetOf(result, sensors[i].name)});
  }
  return tree;
}

SensorTree TreeAbout(const CalibrationResult& result, const std::string& parent,
                     const RigidTransform& T_parent_root) {
  const SensorTree about_root = TreeOf(result);
  SensorTree tree{parent, {{NameOfRoot(result), about_root.parent, T_parent_root, std::nullopt}}};
  for (TreeFrame frame : about_root.frames) {
    frame.T_parent_frame = T_parent_root * frame.T_parent_frame;
    tree.frames.push_back(frame);
  }
  const auto is_parent = [&](const TreeFrame& frame) { return frame.frame == parent; };
  tree.frames.erase(std::remove_if(tree.frames.begin(), tree.frames.end(), is_parent), tree.frames.end());
  return tree;
}

std::optional<RigidTransform> RootInFrame(const CalibrationResult& result, const std::string& frame) {
  const SensorTree tree = TreeOf(result);
  const std::string named = FrameNamed(result, frame);
  if (named == tree.parent) return RigidTransform();
  for (const TreeFrame& candidate : tree.frames) {
    if (candidate.frame == named) return candidate.T_parent_frame.Inverse();
  }
  return std::nullopt;
}

std::string FrameNamed(const CalibrationResult& result, const std::string& frame_or_name) {
  const SensorTree tree = TreeOf(result);
  const auto has_frame = [&](const TreeFrame& frame) { return frame.frame == frame_or_name; };
  if (std::any_of(tree.frames.begin(), tree.frames.end(), has_frame)) return frame_or_name;
  for (const TreeFrame& frame : tree.frames) {
    if (frame.name == frame_or_name) return frame.frame;
  }
  return frame_or_name == NameOfRoot(result) ? tree.parent : frame_or_name;
}

std::vector<std::string> TreeNotes(const SensorTree& tree) {
  std::vector<std::string> notes{
      "Sensor poses found by MLIC, p_parent = T * p_child: metres, where the child stands in the parent.",
      "Time offsets have no place here; t_imu = t_sensor + offset:"};
  bool known = false;
  for (const TreeFrame& frame : tree.frames) {
    if (!frame.time_offset) continue;
    notes.push_back("  " + frame.name + " " + FixedNumber(*frame.time_offset, 9) + " s");
    known = true;
  }
  if (!known) notes.pop_back();
  return notes;
}

std::string XmlComment(const SensorTree& tree, const std::string& indent) {
  std::string text;
  for (const std::string& note : TreeNotes(tree)) {
    text += text.empty() ? indent + "<!-- " : "\n" + indent + "     ";
    text += note;
  }
  return text + " -->\n";
}

}  // namespace mlic
