#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/imu/gyro_integration.h"

namespace mlic {

// A local maximum of the correlation. time_offset: t_imu = t_lidar + time_offset, s. correlation: at most 1.
// R_imu_lidar: the rotation that goes with it; about one axis only it is arbitrary about that axis.
struct CorrelationPeak {
  double time_offset = 0.0;
  double correlation = 0.0;
  Eigen::Quaterniond R_imu_lidar = Eigen::Quaterniond::Identity();
};

// Correlates the LiDAR's mean angular velocities b_k between poses with the IMU's a_k over the same intervals
// shifted by each time offset in [-largest_offset, largest_offset]. Both come from finite rotations, a =
// Log(dR) / dt, so no derivative of a noisy pose is taken. With means removed, which takes the gyroscope's
// bias out,
//   c(offset) = max over R of  sum_k w_k a_k . R b_k / sqrt(sum_k w_k |a_k|^2 * sum_k w_k |b_k|^2)
// which needs no known rotation and, unlike magnitudes, keeps the signs. With R_guess the maximum is not over
// all R, but R = R_guess. Outlier poses are dropped after a first round by their residuals.
//
// Returns the peaks, highest first; none if fewer than 20 intervals are covered by both.
std::vector<CorrelationPeak> CorrelateAngularRates(const GyroIntegration& gyro,
                                                   const std::vector<TimedPose>& poses,
                                                   const std::optional<Eigen::Quaterniond>& R_guess,
                                                   double largest_offset);

}  // namespace mlic
