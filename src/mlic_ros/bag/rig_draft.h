#pragma once

#include <string>
#include <vector>

#include "mlic_core/sensors/rig.h"
#include "mlic_ros/bag/bag_set.h"

namespace mlic {

// A rig file's content guessed from a bag: the fastest IMU, every LiDAR and camera topic, guesses of
// extrinsics from /tf_static and the fixed joints of /tf and of intrinsics from CameraInfo. notes: what was
// left out or chosen, one line each. Throws InputError when the bag has no IMU, or neither LiDAR nor camera.
Rig DraftRig(const BagSet& bags, std::vector<std::string>& notes);

// Gives sensors whose messages have another sensor's frame one of their own, so that the rig file can be
// used.
void MakeFramesUnique(Rig* rig, std::vector<std::string>* notes);

}  // namespace mlic
