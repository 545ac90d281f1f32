#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// A sensor that the exported files place in their root: the IMU, or CalibrationResult::root.
struct ExportedSensor {
  std::string name;
  std::string frame_id;
  RigidTransform T_root_sensor;
};

// All sensors that are given for use; the root itself is not among them.
std::vector<ExportedSensor> ExportedSensors(const CalibrationResult& result);

// The tf frames that the exported files use: the messages' own without a leading slash (tf2 takes none), or
// the sensor's name where a frame is empty, already used by another sensor (a frame has one parent only), or
// holds what roslaunch or xacro would evaluate: frames come from bags and are data, never code.
struct ExportFrames {
  std::string root;                  // the IMU's ("imu" when unknown), or that of CalibrationResult::root
  std::vector<std::string> sensors;  // one for each of the ExportedSensors
  std::vector<std::string> notes;    // one line for each frame that cannot be written
};

ExportFrames FramesOf(const CalibrationResult& result);

// The text with & < > " ' escaped, for XML and HTML.
std::string EscapeXml(const std::string& text);

}  // namespace mlic
