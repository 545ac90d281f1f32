#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_ros/bag/bag_set.h"

namespace mlic {

// What `evaluate` reads besides the calibration itself.

// The trajectory of the first drive, trajectory.tum beside the calibration. InputError when it is not there
// or has fewer than two poses, or poses out of order.
std::vector<StampedPose> ReadTrajectoryBeside(const std::filesystem::path& calibration);

// The images that took part in the calibration, images/keyframes.csv beside calibration.yaml; none when it is
// not there. InputError names a line that is not of the format.
std::vector<CameraKeyframes> ReadKeyframesBeside(const std::filesystem::path& calibration);

// The bag's topics of the calibration's LiDARs and cameras, found by frame_id, where a frame is not unique by
// the name drafted from the topic. InputError names a sensor whose topic is not found, with the bag's topics
// and frames of its kind.
Rig RigOfCalibration(const BagSet& bags, const CalibrationResult& calibration);

// A calibration whose sensors stand where the other one (the truth) says, with its intrinsics; sensors that
// it lacks are left out.
CalibrationResult WithPosesOf(const CalibrationResult& calibration, const CalibrationResult& other);

// A calibration whose LiDARs stand where the rig file guesses them; those without a guess, and cameras, are
// left out. Its time offsets stay: a guess seldom has any.
CalibrationResult AtGuesses(const CalibrationResult& calibration, const Rig& rig);

}  // namespace mlic
