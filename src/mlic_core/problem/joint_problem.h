#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "mlic_core/imu/imu_sigma_course.h"
#include "mlic_core/problem/observations.h"
#include "mlic_core/sensors/bias_course.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/sensors/sensor_id.h"

namespace mlic {

// Which parameters of a camera do not move.
struct FixedCameraParameters {
  bool rotation = false;
  bool translation = false;
  bool time_offset = false;
  bool readout = false;
  std::vector<bool> intrinsics;  // for each parameter; empty: all move
  bool square_pixels = false;    // both focal lengths move, and a prior has them alike
  bool usual_centre = false;     // a prior has the centre near the middle of the image
};

// Of each entry of the IMU's scale and shear, from nothing but that it is an IMU.
// from: standard, data sheets of consumer IMUs: 1 to 3 %
constexpr double kMatrixSigma = 0.02;

// What of the IMU moves beside its biases.
struct ImuFreedom {
  // Of the accelerometer's rotation to the gyroscope: the projector on the axes about which the data show it,
  // and the sigma of its prior about others, rad; 0: it is held.
  Eigen::Matrix3d alignment_shown = Eigen::Matrix3d::Zero();
  double alignment_sigma = 0.0;
  double gravity_sigma = 0.0;  // m/s^2, of the prior about kStandardGravity; 0: gravity is held
  double lag_sigma = 0.0;      // s, of the prior about no lag of the accelerometer; 0: the lag is held
  // Of the prior about no scale error and no shear, where they are estimated.
  double matrix_sigma = kMatrixSigma;
};

// What one drive adds to the problem beside its IMU samples; empty where it has none of a kind.
struct DriveTerms {
  ImuSigmaCourse imu_sigma;  // of the samples; unused while the trajectory is held
  BiasSteps bias_steps;      // of the prior of biases that wander; unused where they are constant
  PlaneAssociation planes;
  std::vector<std::uint64_t>
      plane_voxels;  // of the planes, in ascending order, where the next map keeps to them
  LandmarkSet landmarks;
  PoseObservations poses;
};

// Where one drive's landmarks are.
struct LandmarkGeometry {
  std::vector<MapPlane> planes;
  std::vector<PointLandmark> points;
};

struct LidarTerms {
  std::optional<ExtrinsicGuess> guess;  // the prior; none: nothing is given, or not any more
  bool fixed = false;                   // neither pose nor offset moves
  // What is known of the time offset, s; sigma 0: nothing.
  double given_time_offset = 0.0;
  double time_offset_sigma = 0.0;
};

struct CameraTerms {
  std::optional<ExtrinsicGuess> guess;  // as of a LiDAR
  FixedCameraParameters fixed;
  std::optional<std::vector<double>> given_intrinsics;  // of the rig file
};

// Everything that the joint solve is made of. What is held constant is said by the flags and the mask.
struct JointProblem {
  const Dataset* dataset = nullptr;
  // One for each drive, LiDAR and camera of the state.
  std::vector<DriveTerms> drives;
  std::vector<LidarTerms> lidars;
  std::vector<CameraTerms> cameras;
  bool fix_trajectory = false;         // and the biases
  bool estimate_imu_matrices = false;  // scale and shear
  ImuFreedom imu;
  // Combinations of the sensors' poses and offsets (Layout, up to `poses`) that stay where the guesses have
  // them: row . (state - guess) = 0. Rows are unit vectors, of the translations of sensors with a guess.
  std::vector<Eigen::VectorXd> held_translations;
};

inline const std::optional<ExtrinsicGuess>& GuessOf(SensorId sensor, const JointProblem& problem) {
  return sensor.IsLidar() ? problem.lidars[sensor.index].guess : problem.cameras[sensor.index].guess;
}

}  // namespace mlic
