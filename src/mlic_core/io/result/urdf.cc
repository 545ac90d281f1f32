#include "mlic_core/io/result/urdf.h"

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

// The link of each frame and its joint; `parent` is XML already.
std::string LinksAndJoints(const SensorTree& tree, const std::string& parent, const std::string& indent) {
  std::string text;
  for (const TreeFrame& frame : tree.frames) {
    const std::string link = EscapeXml(frame.frame);
    text += indent + "<link name=\"" + link + "\"/>\n";
    text += indent + "<joint name=\"" + link + "_joint\" type=\"fixed\">\n";
    text += indent + "  <parent link=\"" + parent + "\"/>\n" + indent + "  <child link=\"" + link + "\"/>\n";
    text += indent + "  <origin xyz=\"" + OriginXyz(frame.T_parent_frame) + "\" rpy=\"" +
            OriginRpy(frame.T_parent_frame) + "\"/>\n" + indent + "</joint>\n";
  }
  return text;
}

}  // namespace

std::string OriginXyz(const RigidTransform& pose) { return Triple(pose.translation); }

std::string OriginRpy(const RigidTransform& pose) { return Triple(ToRollPitchYaw(pose.rotation)); }

std::string UrdfText(const SensorTree& tree) {
  const std::string parent = EscapeXml(tree.parent);
  return kHead + XmlComment(tree, "") + "<robot name=\"sensors\" " + kNamespace + ">\n  <link name=\"" +
         parent + "\"/>\n" + LinksAndJoints(tree, parent, "  ") + "</robot>\n";
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
