#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/imu/gyro_integration.h"
#include "mlic_core/initialization/camera_imu/known_rotations.h"
#include "mlic_core/problem/state.h"

namespace mlic {

struct DrivePositions {
  double start = 0.0, end = 0.0;         // s, IMU clock, from the first to the last observation
  PositionSpline positions;              // of the IMU, gyro frame, m; the first is zero
  std::vector<Eigen::Vector3d> gravity;  // gyro frame, at the times of gravity_times, linear between them
  std::vector<double> gravity_times;     // s
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();
};

struct VisualPositions {
  std::string failure;  // not empty: nothing below means anything
  std::vector<DrivePositions> drives;
  std::vector<Eigen::Vector3d> lever_arms;  // of each camera, m
  double scale_sigma = 0.0;                 // relative, of the positions' extent; the largest of the drives
  double accelerometer_rms = 0.0;           // m/s^2, of what positions and gravity do not explain
  double inlier_share = 0.0;                // of observations
};

// Positions p(t) of the IMU, lever arms l_c, gravity g(t) (it turns slowly with the gyro frame's drift) and
// accelerometer bias b, all at once. With the rotations R known everything is linear: for a sample a_m, and
// for an observation of point P along d from c(t) = p(t) + R(t) l,
//   p''(t) - g(t) + R(t) b - R(t) a_m         (m/s^2)
//   (I - d d^T) (P - c(t)) / |P - c(t)|       (rad; the distance from the round before)
// Points are eliminated one by one; what is left is banded in time. The accelerometer sets the scale: no
// structure from motion comes before. Re-weighted rounds do away with outliers and find distances and |g|.
VisualPositions SolvePositions(const KnownRotations& known, const CancellationToken& cancellation);

}  // namespace mlic
