#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/imu/relative_motion.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

struct HandEyeResult {
  // False: nothing below means anything, `failure` says why in one line.
  bool valid = false;
  std::string failure;

  RigidTransform T_imu_lidar;

  // Order: rotation (small left rotation in the IMU frame, rad), translation (m). The information is that of
  // the data alone; the covariance has the guess too (without one: 10 rad and 10 m). Motions that overlap in
  // time share errors: both are divided by `overlap` (see below).
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();

  // What the sigmas of the motions had to be multiplied by to agree with the residuals.
  double rotation_scale = 1.0;
  double translation_scale = 1.0;
  double inlier_share = 0.0;
  // Directions of rotation that the rotations alone (not the translations) show to 0.5 deg.
  int rotation_directions_shown = 0;
};

// T_imu_lidar from motions of IMU and LiDAR over the same intervals:
//   R_I R = R R_L              q_I * q = q * q_L: smallest eigenvector of sum of A^T A, A = L(q_I) - R(q_L),
//   4x4 (R_I - I) p = R t_L - t_I  linear in p
// (Hamilton quaternions.) The closed forms give the start; motions whose angles differ between the two
// sensors, which no rotation can mend, have no part in it. Where rotations about one axis only leave the
// rotation about it open, the translations or the guess decide. Least squares of both equations (Ceres),
// re-weighted with a redescending loss, gives the result. overlap: how many of the motions cover any moment
// (1 for motions that follow each other).
HandEyeResult SolveHandEye(const std::vector<RelativeMotion>& motions,
                           const std::optional<ExtrinsicGuess>& guess, double overlap = 1.0);

}  // namespace mlic
