#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// An initial guess of R_imu_lidar. sigma: of a small left rotation, Exp(rho) * R, along the IMU's axes,
// radians.
struct RotationGuess {
  Eigen::Quaterniond R_imu_lidar = Eigen::Quaterniond::Identity();
  Eigen::Vector3d sigma = Eigen::Vector3d::Constant(5.0 * M_PI / 180.0);
};

struct AngularRateAlignment {
  // False: nothing below means anything, `failure` says why in one line.
  bool valid = false;
  std::string failure;

  double time_offset = 0.0;  // t_imu = t_lidar + time_offset, s
  Eigen::Quaterniond R_imu_lidar = Eigen::Quaterniond::Identity();
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();  // rad/s

  // From the data alone, without the guess; small left rotations in the IMU frame, offset and bias left free,
  // 1/rad^2.
  Eigen::Matrix3d rotation_information = Eigen::Matrix3d::Zero();
  // Its eigenvalues, ascending, and eigenvectors (columns): the first is the direction that the motion shows
  // least.
  Eigen::Vector3d information_values = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information_directions = Eigen::Matrix3d::Identity();
  // With the guess; where neither data nor guess says anything, 10 rad.
  Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();
  // How many of the directions the data show to 0.5 deg (docs/method.md, section 10). Below 3 without a
  // guess, R_imu_lidar is arbitrary about the others.
  int rotation_directions_shown = 0;
  double time_offset_sigma =
      0.0;  // s; about 10 where the motion shows no offset (rest, straight, constant turning)

  // By how much the LiDAR's clock runs slow against the IMU's (s/s), as the offsets of single segments say:
  // theirs is time_offset + clock_drift * (t_lidar - middle of the poses). Sigma from their scatter; infinite
  // where they are too few. All else here knows no drift.
  double clock_drift = 0.0;
  double clock_drift_sigma = std::numeric_limits<double>::infinity();

  double residual_rms = 0.0;  // of inlier poses' orientations, per component, radians
  double inlier_share = 0.0;
  double peak_correlation = 0.0;
  // The highest other peak of the correlation, as a share of the highest; 0 if there is none. Near 1 the
  // motion is periodic and the offset may be wrong by a period.
  double second_peak_ratio = 0.0;
  double second_peak_offset = 0.0;
};

// The least that is asked of an alignment before anything is concluded from it.
bool IsUsable(const AngularRateAlignment& alignment);

// Time offset, rotation and gyroscope bias of a LiDAR to the IMU from the LiDAR's odometry (T_odom_lidar on
// the LiDAR's clock) and the gyroscope. No guess is needed for the offset (up to 1 s) nor, if the motion
// turns about more than one axis, for the rotation. docs/method.md, section 7.1.
//
// The correlation of angular velocities finds the peaks; from the highest ones (at least 0.9 of the best)
// Gauss-Newton with a redescending loss goes on, and the one with the least residuals stays. The poses are
// cut into segments of 2 s with a free orientation R_s each, eliminated in closed form, so that each pose
// counts once and drift does not; the residual of pose k, with c the segment's middle, is
//   Log( (R_s R_il^-1 dR_imu(t_c + offset, t_k + offset) R_il)^-1 R_odom_lidar(t_k) ).
// The guess is a prior on the rotation; it decides where the motion shows nothing. Not by Ceres, whose
// residuals are fixed before a solve: here the cuts move with the offset. Ceres would be no faster: of 16 ms
// a round (60 s drive) nearly all integrates the gyroscope, its elimination alone takes 1.0 ms
// (small_fit_benchmark).
AngularRateAlignment AlignAngularRates(const std::vector<ImuSample>& imu, const std::vector<TimedPose>& poses,
                                       const std::optional<RotationGuess>& guess);

}  // namespace mlic
