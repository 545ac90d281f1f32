#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// The tf frames that the exported files use: the messages' own without a leading slash (tf2 takes none), or
// the sensor's name where a frame is empty or already used by another sensor, since a frame has one parent
// only.
struct ExportFrames {
  std::string imu;                   // "imu" when unknown
  std::vector<std::string> sensors;  // one for each of CalibrationResult::sensors
};

ExportFrames FramesOf(const CalibrationResult& result);

// The text with & < > " ' escaped, for XML and HTML.
std::string EscapeXml(const std::string& text);

}  // namespace mlic
