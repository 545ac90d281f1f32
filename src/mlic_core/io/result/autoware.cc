#include "mlic_core/io/result/autoware.h"

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/io/yaml_reader.h"

namespace mlic {

std::string AutowareText(const SensorTree& tree) {
  std::string text;
  for (const std::string& note : TreeNotes(tree)) text += "# " + note + "\n";
  text += "# Fixed-axis roll, pitch, yaw as in URDF, radians. A camera's frame is the optical one.\n" +
          QuotedYaml(tree.parent) + ":\n";
  for (const TreeFrame& frame : tree.frames) {
    text += "  " + QuotedYaml(frame.frame) + ":\n";
    const Eigen::Vector3d rpy = ToRollPitchYaw(frame.T_parent_frame.rotation);
    const char* const names[] = {"x", "y", "z", "roll", "pitch", "yaw"};
    for (int k = 0; k < 6; ++k) {
      const double value = k < 3 ? frame.T_parent_frame.translation[k] : rpy[k - 3];
      text += "    " + std::string(names[k]) + ": " + FixedNumber(value, 12) + "\n";
    }
  }
  return text;
}

}  // namespace mlic
