#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "mlic_core/imu/relative_motion.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// rad, m, of the scales of robust weights; from: guard, far below noise
constexpr double kSmallestScale = 1e-6;

struct HandEyeRotation {
  Eigen::Quaterniond R_imu_lidar = Eigen::Quaterniond::Identity();
  Eigen::Vector3d open_axis = Eigen::Vector3d::Zero();  // IMU frame, unit: what the rotations show least
  bool open = false;                                    // the rotation about it must be searched
};

// The rotation of SolveHandEye from rotations alone, in closed form: the smallest eigenvector of the sum of
// weighted A^T A (hand_eye.h), re-weighted by what does not fit. Motions whose angles differ between the two
// sensors, which no rotation can mend, have no part in the first round.
HandEyeRotation SolveHandEyeRotation(const std::vector<RelativeMotion>& motions,
                                     const std::optional<ExtrinsicGuess>& guess);

}  // namespace mlic
