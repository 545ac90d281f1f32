#pragma once

#include <string>
#include <vector>

#include "mlic_core/evaluation/calibration_difference.h"
#include "mlic_core/result/result.h"

namespace mlic {

// One pose as several calibrations of a rig have it, each of a drive of its own. Vectors are in the first
// frame (IMU, or a of a pair a/b): metres, and radians of small left rotations.
struct PoseSpread {
  std::string kind;     // such as "lidar-imu" or "lidar-camera"
  std::string name;     // of the sensor, or "a/b"
  int count = 0;        // calibrations that have it
  RigidTransform mean;  // T_imu_sensor, or T_a_b; of rotations the geodesic mean
  // Standard deviations of one calibration; zero of a single one.
  Eigen::Vector3d translation_spread = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_spread = Eigen::Vector3d::Zero();
  // Root mean squares of errors, or of what calibrations differ from their mean by, along each axis; their
  // norms are those of the distance and the angle.
  Eigen::Vector3d translation_rmse = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_rmse = Eigen::Vector3d::Zero();
};

struct Repeatability {
  std::vector<PoseSpread> poses;  // by kind: sensors to the IMU first, then pairs
  bool against_truth = false;
  LargestDifference worst;  // by the claimed sigmas
};

// Errors against the truth, or without one against the mean of all, of which each calibration is a part: what
// n differ from their mean by counts sqrt(n / (n - 1)) times. Sensors are matched by name, IMUs' axes turned
// to the first calibration's (InAxesOf). truth may be null. InputError where there is neither a truth nor a
// second calibration, or no sensor in common.
Repeatability MeasureRepeatability(const std::vector<CalibrationResult>& calibrations,
                                   const CalibrationResult* truth);

// For people: m and cm, degrees; last a line that concludes.
std::string TableOf(const Repeatability& repeatability);

// One line for each pose, header first; metres, degrees.
std::string CsvOf(const Repeatability& repeatability);

// Whether errors are as large as claimed, in one line.
std::string Conclusion(const LargestDifference& worst);

}  // namespace mlic
