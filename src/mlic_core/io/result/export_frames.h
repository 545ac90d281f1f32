#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// The tf frames that the exported files use: the messages' own without a leading slash (tf2 takes none), or
// the sensor's name where a frame is empty, already used by another sensor (a frame has one parent only), or
// holds what roslaunch or xacro would evaluate: frames come from bags and are data, never code.
struct ExportFrames {
  std::string imu;                   // "imu" when unknown
  std::vector<std::string> sensors;  // one for each of CalibrationResult::sensors
  std::vector<std::string> notes;    // one line for each frame that cannot be written
};

ExportFrames FramesOf(const CalibrationResult& result);

// The text with & < > " ' escaped, for XML and HTML.
std::string EscapeXml(const std::string& text);

}  // namespace mlic
