#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/sensors/rig.h"
#include "mlic_sim/camera_sensor.h"
#include "mlic_sim/lidar_model.h"
#include "mlic_sim/material.h"

namespace mlic::sim {

// How a driver writes its points into messages.
enum class PointLayout {
  kVelodyne,   // PointCloud2, time: float32, s relative to the stamp
  kOuster,     // PointCloud2, organised, t: uint32, ns relative to the stamp; beams without return are zero
               // points
  kHesai,      // PointCloud2, timestamp: float64, absolute s
  kRobosense,  // as Hesai, organised, beams without return are NaN
  kLivox,      // livox_ros_driver/CustomMsg, offset_time: uint32, ns relative to timebase
  kNoTime      // PointCloud2 of x, y, z, intensity, ring
};

// A line of vibration that an IMU feels, about and along axes drawn from the seed, with phases drawn from it.
struct VibrationLine {
  double frequency = 0.0;         // Hz
  double specific_force = 0.0;    // amplitude, m/s^2
  double angular_velocity = 0.0;  // amplitude, rad/s
};

// What the biases settle to as an IMU warms up, beyond those at the drive's start.
struct WarmUp {
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero();      // rad/s
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  // m/s^2
  double time_constant = 60.0;                              // s
};

struct SimulatedImu {
  std::string topic = "/imu/data";
  std::string frame_id = "imu_link";
  double rate = 200.0;  // Hz
  RigidTransform T_body_imu;
  ImuNoise noise;                   // white noise densities, rad/s/sqrt(Hz) and m/s^2/sqrt(Hz)
  double gyroscope_walk = 0.0;      // rad/s^2/sqrt(Hz)
  double accelerometer_walk = 0.0;  // m/s^3/sqrt(Hz)
  WarmUp warm_up;
  ImuCalibration calibration;  // measured = matrix * true + bias
  // Cut-offs of second-order Butterworth low-passes as shares of the rate; 0: none.
  double gyroscope_low_pass = 0.0;
  double accelerometer_low_pass = 0.0;
  std::vector<VibrationLine> vibration;
  double gravity = kStandardGravity;  // m/s^2
  double stamp_jitter = 0.0;          // s, standard deviation
  double stamp_step = 0.0;            // s, stamps are whole multiples of it; 0: as they are
  double doubled = 0.0;               // share of samples that come again with the stamp 20 us later
  ImuIntrinsicsModel intrinsics =
      ImuIntrinsicsModel::kBias;  // what the rig file asks the calibration to estimate
};

struct SimulatedLidar {
  std::string name;
  std::string topic;
  std::string frame_id;
  SensorCalibration calibration;  // the truth
  LidarModel model;
  PointLayout layout = PointLayout::kVelodyne;
  bool stamp_at_end = false;  // of the header; relative point times are then negative
  double phase = 0.0;         // start of the first scan after the drive's begin, s, IMU clock
};

// The sensors of a simulated rig with their true calibration, and what is special about the world for them.
struct SensorSet {
  InfraredLook infrared = InfraredLook::kRelated;
  SimulatedImu imu;
  std::vector<SimulatedLidar> lidars;
  std::vector<SimulatedCamera> cameras;
};

// Reads a sensors file (config/simulation/README.md says its keys). Throws InputError with file, line and
// key.
SensorSet LoadSensorSet(const std::filesystem::path& path);

}  // namespace mlic::sim
