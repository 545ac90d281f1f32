#include "mlic_core/io/result/urdf.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

constexpr const char* kHead = "<?xml version=\"1.0\"?>\n";
constexpr const char* kNamespace = "xmlns:xacro=\"http://www.ros.org/wiki/xacro\"";

std::string Triple(const Eigen::Vector3d& v) {
  return FixedNumber(v.x(), 12) + " " + FixedNumber(v.y(), 12) + " " + FixedNumber(v.z(), 12);
}

// A link and its joint; `parent` is XML already.
std::string LinkAndJoint(const std::string& frame, const RigidTransform& T_parent_frame,
                         const std::string& parent, const std::string& indent) {
  const std::string link = EscapeXml(frame);
  return indent + "<link name=\"" + link + "\"/>\n" + indent + "<joint name=\"" + link +
         "_joint\" type=\"fixed\">\n" + indent + "  <parent link=\"" + parent + "\"/>\n" + indent +
         "  <child link=\"" + link + "\"/>\n" + indent + "  <origin xyz=\"" + OriginXyz(T_parent_frame) +
         "\" rpy=\"" + OriginRpy(T_parent_frame) + "\"/>\n" + indent + "</joint>\n";
}

// Those of each frame.
std::string LinksAndJoints(const SensorTree& tree, const std::string& parent, const std::string& indent) {
  std::string text;
  for (const TreeFrame& frame : tree.frames) {
    text += LinkAndJoint(frame.frame, frame.T_parent_frame, parent, indent);
  }
  return text;
}

std::string Robot(const SensorTree& tree, const std::string& links_and_joints) {
  return kHead + XmlComment(tree, "") + "<robot name=\"sensors\" " + kNamespace + ">\n  <link name=\"" +
         EscapeXml(tree.parent) + "\"/>\n" + links_and_joints + "</robot>\n";
}

bool IsCamera(const CalibrationResult& result, const std::string& name) {
  return std::any_of(result.sensors.begin(), result.sensors.end(), [&](const SensorResult& sensor) {
    return sensor.name == name && sensor.type == SensorResult::Type::kCamera;
  });
}

std::string BodyFrame(const std::string& optical) {
  for (const std::string end : {"_optical", "_optical_frame"}) {
    if (optical.size() > end.size() && optical.compare(optical.size() - end.size(), end.size(), end) == 0) {
      return optical.substr(0, optical.size() - end.size());
    }
  }
  return optical + "_body";
}

}  // namespace

std::string OriginXyz(const RigidTransform& pose) { return Triple(pose.translation); }

std::string OriginRpy(const RigidTransform& pose) { return Triple(ToRollPitchYaw(pose.rotation)); }

std::string UrdfText(const SensorTree& tree) {
  return Robot(tree, LinksAndJoints(tree, EscapeXml(tree.parent), "  "));
}

std::string IsaacUrdfText(const CalibrationResult& result, const SensorTree& tree) {
  // z forward, x to the right and y down, seen in x forward, y to the left and z up.
  const RigidTransform T_body_optical{FromRollPitchYaw({-M_PI / 2, 0.0, -M_PI / 2}), Eigen::Vector3d::Zero()};
  std::string text;
  for (const TreeFrame& frame : tree.frames) {
    std::string parent = EscapeXml(tree.parent);
    RigidTransform pose = frame.T_parent_frame;
    if (IsCamera(result, frame.name)) {
      const std::string body = BodyFrame(frame.frame);
      text += LinkAndJoint(body, pose * T_body_optical.Inverse(), parent, "  ");
      parent = EscapeXml(body);
      pose = T_body_optical;
    }
    text += LinkAndJoint(frame.frame, pose, parent, "  ");
  }
  return Robot(tree, text);
}

std::string UrdfMacroText(const SensorTree& tree) {
  // A default with a blank or a quote in it is more than xacro's list of parameters takes.
  const bool plain = tree.parent.find_first_of(" '\"") == std::string::npos;
  return kHead + XmlComment(tree, "") +
         "<!-- In a model that has the parent's link: <xacro:include filename=\"sensors_macro.xacro\"/> "
         "<xacro:mlic_sensors/> -->\n<robot " +
         kNamespace + ">\n  <xacro:macro name=\"mlic_sensors\" params=\"parent" +
         (plain ? ":=" + EscapeXml(tree.parent) : "") + "\">\n" + LinksAndJoints(tree, "${parent}", "    ") +
         "  </xacro:macro>\n</robot>\n";
}

}  // namespace mlic
