#include "mlic_core/io/result/export_frames.h"

#include <set>

namespace mlic {
namespace {

std::string WithoutLeadingSlash(const std::string& frame) {
  return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame;
}

}  // namespace

ExportFrames FramesOf(const CalibrationResult& result) {
  ExportFrames frames;
  frames.imu = WithoutLeadingSlash(result.imu_frame_id);
  if (frames.imu.empty()) frames.imu = "imu";
  std::set<std::string> used{frames.imu};
  for (const SensorResult& sensor : result.sensors) {
    std::string frame = WithoutLeadingSlash(sensor.frame_id);
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
