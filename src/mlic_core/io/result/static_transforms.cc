#include "mlic_core/io/result/static_transforms.h"

#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {

void WriteStaticTransforms(const std::filesystem::path& path, const CalibrationResult& result) {
  const ExportFrames frames = FramesOf(result);
  const std::vector<ExportedSensor> sensors = ExportedSensors(result);
  const std::string root = result.root.empty() ? "the IMU's frame" : "the frame of " + result.root;
  std::string text =
      "<!-- Sensor poses found by MLIC: metres and quaternions x y z w, in " + root + ". -->\n<launch>\n";
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const RigidTransform& pose = sensors[i].T_root_sensor;
    std::string arguments;
    for (int k = 0; k < 3; ++k) arguments += FixedNumber(pose.translation[k], 9) + " ";
    for (int k = 0; k < 4; ++k) arguments += FixedNumber(pose.rotation.coeffs()[k], 12) + " ";
    text += "  <node pkg=\"tf2_ros\" type=\"static_transform_publisher\" name=\"mlic_" +
            EscapeXml(sensors[i].name) + "\"\n        args=\"" + arguments +
            EscapeXml(ShellQuoted(frames.root)) + " " + EscapeXml(ShellQuoted(frames.sensors[i])) + "\"/>\n";
  }
  WriteFileAtomically(path, text + "</launch>\n");
}

}  // namespace mlic
