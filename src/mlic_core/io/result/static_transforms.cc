#include "mlic_core/io/result/static_transforms.h"

#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

constexpr const char* kPeriod = " 100";  // ms, as often as tf's own examples publish; from: standard

}  // namespace

std::string StaticTransformsText(const SensorTree& tree, TransformPublisher publisher) {
  const bool tf = publisher == TransformPublisher::kTf;
  std::string text = XmlComment(tree, "") + "<!-- args: x y z qx qy qz qw PARENT CHILD" +
                     (tf ? " MILLISECONDS" : "") + " -->\n<launch>\n";
  for (const TreeFrame& frame : tree.frames) {
    const RigidTransform& pose = frame.T_parent_frame;
    std::string arguments;
    for (int k = 0; k < 3; ++k) arguments += FixedNumber(pose.translation[k], 12) + " ";
    for (int k = 0; k < 4; ++k) arguments += FixedNumber(pose.rotation.coeffs()[k], 12) + " ";
    text += "  <node pkg=\"" + std::string(tf ? "tf" : "tf2_ros") +
            "\" type=\"static_transform_publisher\" name=\"mlic_" + EscapeXml(frame.name) +
            "\"\n        args=\"" + arguments + EscapeXml(ShellQuoted(tree.parent)) + " " +
            EscapeXml(ShellQuoted(frame.frame)) + (tf ? kPeriod : "") + "\"/>\n";
  }
  return text + "</launch>\n";
}

}  // namespace mlic
