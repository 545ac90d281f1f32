#pragma once

#include <string>
#include <vector>

#include "mlic_core/io/yaml_reader.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// Parts of the rig file, one function for each block of it; LoadRigFile puts them together.

// Names in the order of the enums.
const std::vector<std::string>& CameraModelNames();
const std::vector<std::string>& ShutterNames();
const std::vector<std::string>& ImuIntrinsicsNames();

// Number of distortion terms after fx fy cx cy.
std::size_t DistortionCount(CameraModel model);

ImuConfig ParseImu(const YamlReader& imu);
// `enabled` is set from the key of that name.
LidarConfig ParseLidar(const YamlReader& lidar, bool* enabled);
CameraConfig ParseCamera(const YamlReader& camera, bool* enabled);

// A quaternion x y z w, of unit length within 1 percent; normalised, w >= 0.
Eigen::Quaterniond ParseQuaternion(const YamlReader& rotation);

}  // namespace mlic
