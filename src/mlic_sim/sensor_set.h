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

struct SimulatedImu {
  std::string topic = "/imu/data";
  std::string frame_id = "imu_link";
  double rate = 200.0;  // Hz
  RigidTransform T_body_imu;
  ImuNoise noise;                   // white noise densities, rad/s/sqrt(Hz) and m/s^2/sqrt(Hz)
  double gyroscope_walk = 0.0;      // rad/s^2/sqrt(Hz)
  double accelerometer_walk = 0.0;  // m/s^3/sqrt(Hz)
  ImuCalibration calibration;       // measured = matrix * true + bias
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
