#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/sensors/bias_course.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/sensors/sensor_id.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// All that is estimated but for the planes, which are found anew for each solve. The map of each drive is
// aligned to gravity.
struct DriveState {
  SplitSpline trajectory;  // T_map_imu
  BiasCourse bias;         // of the IMU
};

struct CameraCalibration {
  SensorCalibration sensor;  // the time offset belongs to row 0, in the middle of its exposure
  CameraIntrinsics intrinsics;
  bool rolling_shutter = false;
  double readout = 0.0;  // s, from row 0 to the row below the last; 0 for global shutters
};

// What a ring's points need added: to the range (m) and to the elevation (rad).
struct RingCorrection {
  float range = 0.0f;
  float elevation = 0.0f;
};
using RingCorrections = std::vector<RingCorrection>;  // by ring; rings beyond its end need none

// What all ranges of a LiDAR need added: offset + slope * elevation + walk * log10(intensity / reference).
struct RangeCorrection {
  double offset = 0.0;     // m
  double slope = 0.0;      // m/rad
  double walk = 0.0;       // m, by which echoes that are ten times weaker seem longer
  double reference = 0.0;  // the usual intensity, as the LiDAR reports it; 0 where it reports none
};

struct CalibrationState {
  std::vector<SensorCalibration> lidars;
  std::vector<RingCorrections> rings;   // of each LiDAR; empty: none
  std::vector<RangeCorrection> ranges;  // of each LiDAR; empty: none
  std::vector<CameraCalibration> cameras;
  Eigen::Matrix3d gyroscope_matrix = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d accelerometer_matrix = Eigen::Matrix3d::Identity();
  // Projector on the directions about which the IMU's axes are the accelerometer's; about others they are the
  // gyroscope's. Only through SetAccelerometerAxes.
  Eigen::Matrix3d accelerometer_axes = Eigen::Matrix3d::Zero();
  double gravity = kStandardGravity;  // m/s^2, its magnitude
  double accelerometer_lag = 0.0;     // s, ImuCalibration
  std::vector<DriveState> drives;

  SensorOrder Sensors() const { return {lidars.size(), cameras.size()}; }
  const SensorCalibration& Sensor(SensorId id) const {
    return id.IsLidar() ? lidars[id.index] : cameras[id.index].sensor;
  }

  Eigen::Vector3d Gravity() const { return {0.0, 0.0, -gravity}; }  // in the map, m/s^2
  // At a time of the drive, s.
  ImuCalibration Imu(std::size_t drive, double time) const { return ImuWith(drives[drive].bias.Value(time)); }
  // With the mean of the drive's biases.
  ImuCalibration MeanImu(std::size_t drive) const { return ImuWith(drives[drive].bias.Mean()); }

 private:
  ImuCalibration ImuWith(const BiasCourse::Bias& bias) const {
    return {bias.head<3>(), bias.tail<3>(), gyroscope_matrix, accelerometer_matrix, accelerometer_lag};
  }
};

// Turns the IMU's axes to those of the accelerometer about the directions of a projector, and of the
// gyroscope about others: poses of sensors, trajectories and matrices of the IMU are in the new ones.
void SetAccelerometerAxes(const Eigen::Matrix3d& directions, CalibrationState* state);

// Every number of it is one: no pose, offset, intrinsic, bias or control point is infinite or not a number.
bool IsFinite(const CalibrationState& state);

// In the map, m/s^2, until it is estimated.
const Eigen::Vector3d kGravity(0.0, 0.0, -kStandardGravity);

}  // namespace mlic
