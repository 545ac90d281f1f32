#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/initialization/camera_imu/known_rotations.h"

namespace mlic {

// A camera's observation of a point when only rotations are known.
struct DirectionObservation {
  int camera = 0;
  double time = 0.0;          // IMU clock
  Eigen::Matrix3d rotation;   // of the IMU in the gyro frame
  Eigen::Vector3d direction;  // unit, gyro frame
  Eigen::Vector3d ray;        // unit, gyro frame, to the point as far as known
  double sigma = 0.01;        // rad
  double distance = 1.0;      // m, to the point, as far as known
  double weight = 1.0;        // robust
};

struct PointObservations {
  std::size_t drive = 0;
  std::vector<DirectionObservation> observations;  // at least two, within the longest duration
};

// The tracks of the cameras that were found as observations. Tracks are cut where they last longer than
// `longest` (s); parts whose observations turn by less than rounding against each other do not tell of motion
// and are left out. Distances are guessed from the parallax, as if the rig moved at 1 m/s.
std::vector<PointObservations> CollectObservations(const KnownRotations& known, double longest);

}  // namespace mlic
