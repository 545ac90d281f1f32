#include "mlic_core/io/result/urdf.h"

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

std::string Triple(const Eigen::Vector3d& v) {
  return FixedNumber(v.x(), 12) + " " + FixedNumber(v.y(), 12) + " " + FixedNumber(v.z(), 12);
}

}  // namespace

void WriteUrdf(const std::filesystem::path& path, const CalibrationResult& result) {
  const ExportFrames frames = FramesOf(result);
  std::string text =
      "<?xml version=\"1.0\"?>\n<!-- Sensor poses found by MLIC: metres, fixed-axis rpy in radians. -->\n";
  text += "<robot name=\"sensors\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n";
  text += "  <link name=\"" + EscapeXml(frames.root) + "\"/>\n";
  const std::vector<ExportedSensor> sensors = ExportedSensors(result);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const RigidTransform& pose = sensors[i].T_root_sensor;
    const std::string link = EscapeXml(frames.sensors[i]);
    text += "  <link name=\"" + link + "\"/>\n";
    text += "  <joint name=\"" + link + "_joint\" type=\"fixed\">\n";
    text += "    <parent link=\"" + EscapeXml(frames.root) + "\"/>\n    <child link=\"" + link + "\"/>\n";
    text += "    <origin xyz=\"" + Triple(pose.translation) + "\" rpy=\"" +
            Triple(ToRollPitchYaw(pose.rotation)) + "\"/>\n  </joint>\n";
  }
  WriteFileAtomically(path, text + "</robot>\n");
}

}  // namespace mlic
