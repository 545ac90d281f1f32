#pragma once

#include <string>
#include <vector>

#include "mlic_core/io/result/robot_model.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// What a robot's model says of a rig, as a calibration: the poses of its sensors to the IMU and to each
// other, by the frames of the rig and over fixed joints, as exact (sigmas of zero). Time offsets are not
// known: their sigmas are NaN. Cameras have the rig's intrinsics. left_out: a line for each sensor that the
// model does not place or whose intrinsics the rig lacks. InputError where the model has no link of the IMU.
CalibrationResult CalibrationOfModel(const RobotModel& model, const Rig& rig,
                                     std::vector<std::string>* left_out);

// Gives the rig's sensors the poses of their frames in a robot's model, over fixed joints, as guesses with
// the usual sigmas, in place of those that they have. notes: a line for each that the model does not place,
// which keeps what it has. InputError where the model has no link of the IMU.
void TakeGuesses(const RobotModel& model, Rig* rig, std::vector<std::string>* notes);

}  // namespace mlic
