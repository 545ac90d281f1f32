#pragma once

#include <Eigen/Core>
#include <string>

#include "mlic_core/io/result/sensor_tree.h"
#include "mlic_core/result/result.h"

namespace mlic {

// A whole model: a link for the parent and one for each frame, fixed joints between them. It holds no macro,
// so xacro, check_urdf and robot_state_publisher all take it as it is.
std::string UrdfText(const SensorTree& tree);

// A file for a vehicle's own xacro to include: the macro mlic_sensors makes the links of all frames but the
// parent, and their joints below the link that its parameter `parent` names.
std::string UrdfMacroText(const SensorTree& tree);

// As UrdfText, with two links for each camera, as Isaac ROS wants a robot's calibration: one with x forward,
// y to the left and z up (REP 103), and below it the optical one, which has the frame of the images. The
// first is named as the optical one without "_optical" or "_optical_frame" at its end, or with "_body" added.
std::string IsaacUrdfText(const CalibrationResult& result, const SensorTree& tree);

// What the attributes of a URDF origin hold.
std::string OriginXyz(const RigidTransform& pose);
std::string OriginRpy(const RigidTransform& pose);

}  // namespace mlic
