#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// Continuous-time white-noise densities: rad/s/sqrt(Hz) and m/s^2/sqrt(Hz).
struct ImuNoise {
  double gyroscope = 0.0;
  double accelerometer = 0.0;
};

enum class ImuIntrinsicsModel { kBias, kScaleMisalignment };

// An initial guess of an extrinsic. Sigmas: along the IMU's axes, metres; small left rotation in the IMU
// frame, radians.
struct ExtrinsicGuess {
  RigidTransform T_imu_sensor;
  Eigen::Vector3d sigma_translation = Eigen::Vector3d::Constant(0.1);
  Eigen::Vector3d sigma_rotation = Eigen::Vector3d::Constant(5.0 * M_PI / 180.0);
};

// Sigmas of a sensor that is held: of its pose as those of ExtrinsicGuess, of its time offset in s.
struct HeldSigma {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
  double time_offset = 0.0;
};

// Gravity on the ground is within 0.03 m/s^2 of it (9.780 at the equator, 9.832 at the poles).
constexpr double kStandardGravity = 9.81;  // m/s^2; from: definition
// Of gravity about it, m/s^2. from: standard, the normal gravity formula of WGS 84 gives 9.780 at the equator
// and 9.832 at the poles
constexpr double kGravitySigma = 0.03;

struct ImuConfig {
  std::string topic;
  std::string frame_id;  // empty: the messages' own
  std::optional<ImuNoise> noise;
  ImuIntrinsicsModel intrinsics = ImuIntrinsicsModel::kBias;
  // rad, of the accelerometer's axes to the gyroscope's. from: standard, data sheets of consumer IMUs, 1 deg
  double alignment_sigma = 1.0 * M_PI / 180.0;
  std::optional<double> gravity;  // m/s^2, held; otherwise estimated near kStandardGravity
  // Unit vectors about which the axes that guesses are to are the accelerometer's, and the gyroscope's about
  // others. None: not known, the calibration's are chosen by what its drive shows.
  std::optional<std::vector<Eigen::Vector3d>> accelerometer_axes;
};

struct LidarConfig {
  std::string name;
  std::string topic;
  std::string frame_id;  // empty: the messages' own
  std::optional<ExtrinsicGuess> guess;
  std::optional<double> time_offset;    // s, an initial guess
  bool fixed = false;                   // hold guess and time offset
  std::optional<HeldSigma> held_sigma;  // of these, where fixed; none: exact
};

enum class Shutter { kGlobal, kRolling };

struct CameraConfig {
  std::string name;
  std::string topic;
  std::string frame_id;
  CameraModel model = CameraModel::kPlumbBob;
  std::optional<double> fov_deg;                  // horizontal
  std::optional<std::vector<double>> intrinsics;  // fx fy cx cy and the distortion
  bool intrinsics_fixed = false;                  // hold these
  Shutter shutter = Shutter::kGlobal;
  std::string mask;  // path, relative to the rig file
  std::optional<ExtrinsicGuess> guess;
  std::optional<double> time_offset;
  bool fixed = false;
  std::optional<HeldSigma> held_sigma;
};

// How the sensors are arranged and where their data are: the rig file's content, enabled sensors only.
struct Rig {
  ImuConfig imu;
  std::vector<LidarConfig> lidars;
  std::vector<CameraConfig> cameras;
};

// measured = gyroscope_matrix * true + gyroscope_bias, likewise for the accelerometer.
struct ImuCalibration {
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gyroscope_matrix = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d accelerometer_matrix = Eigen::Matrix3d::Identity();
  // s, by which the accelerometer's readings are later than the gyroscope's under the same stamp
  double accelerometer_lag = 0.0;
};

// By how much two crystals drift apart.
constexpr double kFastestCrystals = 1e-4;  // s/s; from: standard, data sheets: 50 ppm each at most

// Pose and clock of one sensor: p_imu = T_imu_sensor * p_sensor,
//   t_imu = t_sensor + time_offset + clock_drift * (t_sensor - middle),
// middle: of the drive, on the sensor's clock, so that offset and drift hardly hang on each other.
struct SensorCalibration {
  RigidTransform T_imu_sensor;
  double time_offset = 0.0;
  std::optional<double> clock_drift = std::nullopt;  // s/s; none: it is not estimated, and there is none

  // Times in s since the drive's epoch.
  double OnImuClock(double time, double middle) const { return time + OffsetAt(time - middle); }
  double OffsetAt(double from_middle) const { return time_offset + clock_drift.value_or(0.0) * from_middle; }
  double OnOwnClock(double imu_time, double middle) const {
    const double drift = clock_drift.value_or(0.0);
    return (imu_time - time_offset + drift * middle) / (1.0 + drift);
  }
};

}  // namespace mlic
