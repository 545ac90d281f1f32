#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/inspection/finding.h"
#include "mlic_core/inspection/pose_information.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// Which directions of an extrinsic the motion will show, and to how much, from the IMU's samples alone: a
// Cramer-Rao estimate for one sensor whose poses in the map are known to white noise. With phi, p, tau the
// sensor's rotation (small, left), lever arm and time offset, b_w, b_a the biases, gamma gravity's direction
// in the map, and w, a, R the IMU's rate, specific force and attitude, the IMU's residuals (docs/method.md,
// section 3) change by
//   d r_w = -[w]x phi + w' tau + b_w
//   d r_a = -[a]x (phi + alpha) - ([w']x + [w]x^2) p + a' tau + b_a + R^T ([g]x gamma + up g)
// where alpha is the accelerometer's rotation to the gyroscope, free where the calibration frees it, and g
// gravity's magnitude.
// The poses' noise, differentiated once and twice, adds to that of the IMU at frequency f in the densities
//   S_w = s_w^2 + (2 pi f)^2 s_phi^2,   S_a = s_a^2 + (2 pi f)^4 s_p^2,
// each along the axes on which the poses' noise is independent. The whitening filters are low-passes: of
// first order, and Butterworth's of second order.

// A direction whose sigma exceeds the limit of what counts as observable (docs/conventions.md).
struct UnseenDirection {
  std::string quantity;                                 // "rotation", "translation", "time_offset"
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit, in the IMU frame; zero for the time offset
  double sigma = 0.0;                                   // rad, m, s; from the data alone
};

struct ObservabilityForecast {
  // With the default sigmas of a guess (sensors/rig.h) along the directions that are not shown.
  Eigen::Vector3d rotation_sigma = Eigen::Vector3d::Zero();     // rad, along the IMU's axes
  Eigen::Vector3d translation_sigma = Eigen::Vector3d::Zero();  // m
  double time_offset_sigma = 0.0;                               // s
  std::vector<UnseenDirection> unseen;
  // What it rests on.
  ImuNoise imu_noise;  // densities of the noisiest axes
  PoseNoise pose_noise;
};

// imu: the rig file's; its noise is measured from the samples where absent. poses: along the IMU's axes.
// Nothing for less than two seconds.
std::optional<ObservabilityForecast> ForecastObservability(const std::vector<ImuSample>& samples,
                                                           const ImuConfig& imu, const PoseNoise& poses);

// What the forecast means for each sensor of the rig: a direction that is not shown stays at the guess, or
// loses the sensor's link to the IMU where there is none.
Findings ForecastFindings(const ObservabilityForecast& forecast, const Rig& rig);

}  // namespace mlic
