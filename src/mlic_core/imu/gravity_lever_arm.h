#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// An initial guess of p_imu_lidar (the LiDAR's position in the IMU frame), metres; sigma along the IMU's
// axes.
struct LeverArmGuess {
  Eigen::Vector3d p_imu_lidar = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma = Eigen::Vector3d::Constant(0.1);
};

struct GravityLeverArm {
  // False: nothing below means anything, `failure` says why in one line.
  bool valid = false;
  std::string failure;

  Eigen::Vector3d gravity = Eigen::Vector3d(0.0, 0.0, -9.81);  // in the odometry frame, of length 9.81 m/s^2
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  // m/s^2
  Eigen::Vector3d p_imu_lidar = Eigen::Vector3d::Zero();         // m

  // The rotation given, corrected within its covariance: on a plane, accelerations show the heading that
  // turning does not. Small left rotations in the IMU frame, rad^2.
  Eigen::Quaterniond R_imu_lidar = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();

  // Of p_imu_lidar from the data alone, gravity, bias and rotation left free within their priors, 1/m^2. A
  // direction with hardly any information is one that the motion does not show (z on a plane).
  Eigen::Matrix3d lever_arm_information = Eigen::Matrix3d::Zero();
  // With the guess; without one the prior is zero with 10 m.
  Eigen::Matrix3d lever_arm_covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d accelerometer_bias_covariance = Eigen::Matrix3d::Zero();
  double gravity_direction_sigma = 0.0;  // rad, the larger of the two directions

  double residual_rms = 0.0;  // of inlier positions, per component, m
  double inlier_share = 0.0;
};

// Gravity, accelerometer bias and lever arm from a LiDAR's odometry (T_odom_lidar on the LiDAR's clock) and
// the IMU, when offset (t_imu = t_lidar + time_offset) and gyroscope bias are known, and the rotation up to
// rotation_covariance (small left rotations in the IMU frame, rad^2, as AngularRateAlignment gives it; zero
// fixes the rotation). Errors of offset and bias are not in the covariances. docs/method.md, section 7.2.
//
// Positions, never their second derivatives: poses are cut into segments of 2 s with a free position p_0 and
// velocity v_0 of the IMU and a small tilt delta of the segment's orientation R_c (within what the odometry's
// noise allows), eliminated in closed form. With T the time since the segment's middle c, D_k and beta_k the
// integrated gyroscope and the doubly integrated specific force from c to pose k, B_k the latter's Jacobian
// to the bias, the residual is
//   p_odom_lidar(t_k) - R_c Exp(delta) (D_k p_imu_lidar + beta_k - B_k b_a) - p_0 - v_0 T - g T^2 / 2.
// Linear but for |g| = 9.81, solved by robust re-weighting; the prior of b_a is zero with 0.2 m/s^2.
// Own elimination and not Ceres: 21 ms for all of the 21 rounds of a 60 s drive, integration included, where
// Ceres' Schur elimination alone takes 1.5 ms in each (small_fit_benchmark).
GravityLeverArm SolveGravityLeverArm(const std::vector<ImuSample>& imu, const std::vector<TimedPose>& poses,
                                     const Eigen::Quaterniond& R_imu_lidar, double time_offset,
                                     const Eigen::Vector3d& gyroscope_bias,
                                     const std::optional<LeverArmGuess>& guess,
                                     const Eigen::Matrix3d& rotation_covariance = Eigen::Matrix3d::Zero());

}  // namespace mlic
