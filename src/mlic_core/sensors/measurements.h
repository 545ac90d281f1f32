#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "mlic_core/common/time.h"
#include "mlic_core/sensors/images.h"

namespace mlic {

// One IMU sample. time: seconds since the drive's epoch, on the IMU clock. rad/s and m/s^2 (specific force:
// at rest with z up, z reads about +9.81), in the IMU frame.
struct ImuSample {
  double time = 0.0;
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();
};

// One return. Metres in the sensor frame; time: seconds after the scan's time; intensity as the driver writes
// it.
struct LidarPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  float time = 0.0f;
  float intensity = 0.0f;
  std::uint16_t ring = 0;
};

// The points of one sweep in order of time. time: of the point with time 0, seconds since the drive's epoch,
// on the LiDAR's own clock (t_imu = t_sensor + time_offset).
struct LidarScan {
  double time = 0.0;
  std::vector<LidarPoint> points;
};

// What one LiDAR recorded in one drive. Scans are in order of time and thinned out at loading
// (lidar/scan_filter.h).
struct LidarRecording {
  std::vector<LidarScan> scans;
  double scan_period = 0.1;               // median time between scans, s
  bool point_times_from_azimuth = false;  // the message had none: reconstructed, good to some milliseconds
};

// One continuous recording. lidars[i] belongs to Rig::lidars[i] (enabled ones, in the rig file's order).
struct Drive {
  TimeNs epoch = 0;  // absolute time of time 0
  std::vector<ImuSample> imu;
  std::vector<LidarRecording> lidars;
  std::vector<CameraRecording> cameras;  // cameras[i] belongs to Rig::cameras[i]
};

// All that was recorded, one or several drives with the same rig. Const once loaded.
struct Dataset {
  std::vector<Drive> drives;
};

// Of all drives together.
inline std::size_t ImuSampleCount(const Dataset& dataset) {
  std::size_t count = 0;
  for (const Drive& drive : dataset.drives) count += drive.imu.size();
  return count;
}

}  // namespace mlic
