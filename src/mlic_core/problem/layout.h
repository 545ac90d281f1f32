#pragma once

#include <vector>

#include "mlic_core/problem/state.h"

namespace mlic {

// Where each parameter stands in the vector of unknowns: the control points of all drives in order of time
// (which keeps the matrix banded), then the calibration: for each LiDAR, then for each camera, rotation
// (left perturbation, 3), translation (3) and time offset (1); for each camera readout (1, rolling shutters
// only) and intrinsics (as many as its model has); the IMU's matrices (15, if estimated); for each drive
// gyroscope and accelerometer bias (6).
struct Layout {
  struct DriveKnots {
    std::vector<int> rotation;  // first index of each control point
    std::vector<int> position;
  };
  std::vector<DriveKnots> drives;
  int knots = 0;        // scalars
  int bandwidth = 0;    // below the diagonal, scalars
  int calibration = 0;  // scalars
  int sensors = 0;      // LiDARs and cameras
  int matrices = -1;    // index within the calibration, -1: not estimated
  int biases = 0;       // index within the calibration of the first drive's

  Layout(const CalibrationState& state, bool with_imu_matrices);

  int Total() const { return knots + calibration; }
  static int Lidar(std::size_t lidar) { return 7 * static_cast<int>(lidar); }
  int Camera(std::size_t camera) const { return first_camera + 7 * static_cast<int>(camera); }
  int Readout(std::size_t camera) const { return readout[camera]; }  // -1: a global shutter
  int Intrinsics(std::size_t camera) const { return intrinsics[camera]; }
  int Bias(std::size_t drive) const { return biases + 6 * static_cast<int>(drive); }

  // The state moved by `delta` (Total()).
  void Update(const Eigen::VectorXd& delta, CalibrationState* state) const;

  int first_camera = 0;         // index within the calibration
  std::vector<int> readout;     // of each camera
  std::vector<int> intrinsics;  // of each camera's first parameter
};

}  // namespace mlic
