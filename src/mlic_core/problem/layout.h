#pragma once

#include <vector>

#include "mlic_core/problem/state.h"

namespace mlic {

// Where each parameter stands in the vector of unknowns: the control points of all drives in order of time
// (which keeps the matrix banded), then the calibration: for each LiDAR, then for each camera, rotation
// (left perturbation, 3), translation (3) and time offset (1); for each camera readout (1, rolling shutters
// only) and intrinsics (as many as its model has); for each sensor whose clock's drift is estimated that (1);
// gravity's magnitude (1); the accelerometer's lag (1) and rotation to the gyroscope (3: left perturbation of
// its matrix, and about CalibrationState::accelerometer_axes the opposite right one of the gyroscope's);
// scale and shear of the IMU (12, if estimated: ImuResidual); for each drive, for each knot of the biases'
// course, gyroscope and accelerometer bias (6).
struct Layout {
  static constexpr int kOfSensor = 7;     // scalars of one sensor's pose and offset; from: structural
  static constexpr int kOfMatrices = 12;  // scalars of scale and shear; from: structural
  static constexpr int kOfBias = 6;       // scalars of gyroscope and accelerometer bias; from: structural

  struct DriveKnots {
    std::vector<int> rotation;  // first index of each control point
    std::vector<int> position;
  };
  std::vector<DriveKnots> drives;
  int knots = 0;        // scalars
  int bandwidth = 0;    // below the diagonal, scalars
  int calibration = 0;  // scalars
  int poses = 0;        // scalars of the sensors' poses and offsets, which come first in the calibration
  int gravity = 0;      // index within the calibration
  int lag = 0;          // index within the calibration of the accelerometer's lag
  int alignment = 0;    // index within the calibration of the accelerometer's rotation
  int matrices = -1;    // index within the calibration of scale and shear, -1: not estimated

  Layout(const CalibrationState& state, bool with_imu_matrices);

  int Total() const { return knots + calibration; }
  // Where the pose and offset of the sensor at a place of the SensorOrder begin.
  static int Sensor(std::size_t place) { return kOfSensor * static_cast<int>(place); }
  static int Lidar(std::size_t lidar) { return Sensor(lidar); }  // LiDARs come first
  int Camera(std::size_t camera) const { return Sensor(order.PlaceOf(CameraId(camera))); }
  int Readout(std::size_t camera) const { return readout[camera]; }  // -1: a global shutter
  int Intrinsics(std::size_t camera) const { return intrinsics[camera]; }
  int Drift(SensorId sensor) const { return drift[order.PlaceOf(sensor)]; }  // -1: not estimated
  int Bias(std::size_t drive, int knot) const { return bias[drive] + kOfBias * knot; }

  // The state moved by `delta` (Total()).
  void Update(const Eigen::VectorXd& delta, CalibrationState* state) const;

  SensorOrder order;
  std::vector<int> readout;     // of each camera
  std::vector<int> intrinsics;  // of each camera's first parameter
  std::vector<int> drift;       // of each sensor, in the order
  std::vector<int> bias;        // of each drive's first knot
};

}  // namespace mlic
