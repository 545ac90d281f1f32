#pragma once

#include <Eigen/Core>

#include "mlic_core/common/time.h"

namespace mlic {

// One IMU message at its absolute time. rad/s and m/s^2 (specific force).
struct StampedImu {
  TimeNs stamp = 0;
  TimeNs record = 0;
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();
};

}  // namespace mlic
