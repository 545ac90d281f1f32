#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// A frame of the calibration below the parent of its tree.
struct TreeFrame {
  std::string name;   // of the sensor; "imu" of the IMU
  std::string frame;  // in tf and URDF, see FramesOf
  RigidTransform T_parent_frame;
  std::optional<double> time_offset;  // s; none: of the IMU, and where it is not known
};

// What files of poses place: frames, each directly below the parent.
struct SensorTree {
  std::string parent;
  std::vector<TreeFrame> frames;
};

// The sensors about the IMU or CalibrationResult::root.
SensorTree TreeOf(const CalibrationResult& result);

// The same about another frame, and the IMU (or root) too; without the frame that is the parent itself.
SensorTree TreeAbout(const CalibrationResult& result, const std::string& parent,
                     const RigidTransform& T_parent_root);

// The pose of the IMU (or root) in a frame of the calibration, or in that of the sensor of this name; none
// where it is neither.
std::optional<RigidTransform> RootInFrame(const CalibrationResult& result, const std::string& frame);

// The frame by which tf and URDF know it: that of a sensor where a name is given.
std::string FrameNamed(const CalibrationResult& result, const std::string& frame_or_name);

// Lines for a comment: what the numbers of a tree mean, and the time offsets, for which tf and URDF have no
// place. Without two hyphens in a row, which end a comment in XML.
std::vector<std::string> TreeNotes(const SensorTree& tree);

// The same as an XML comment, indented.
std::string XmlComment(const SensorTree& tree, const std::string& indent);

}  // namespace mlic
