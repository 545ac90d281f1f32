#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mlic_core/common/time.h"

namespace mlic {

// One IMU message at its absolute time.
struct StampedImu {
  TimeNs stamp = 0;
  TimeNs record = 0;
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();
};

struct ImuCounts {
  std::size_t not_finite = 0;
  std::size_t duplicates = 0;
  std::size_t frozen = 0;     // a driver that hangs repeats its last reading
  std::size_t saturated = 0;  // an axis at the end of its range
};

// Drops samples that are not finite, sorts by stamp, drops repeated stamps and what is not measured (frozen
// and saturated readings; where nearly all are alike, as in a simulation without noise, none counts as
// frozen), and checks the units: specific force in m/s^2 with gravity in it, angular velocity in rad/s.
// Throws InputError, starting with the topic, when nothing finite is left or when a unit is wrong, saying
// which one it looks like.
ImuCounts CleanImu(std::vector<StampedImu>& samples, const std::string& topic);

}  // namespace mlic
