#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/lidar/plane_map.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/solver/normal_equations.h"

namespace mlic {

// A point tied to a plane.
struct PlaneObservation {
  Eigen::Vector3f position;  // LiDAR frame, its ring's correction applied
  float sigma;               // m, along the beam
  float cos_incidence;
  float intensity;
  std::int32_t lidar;
  std::uint16_t ring;
  double time;  // LiDAR clock
};

// One drive's planes and the points tied to each, in order of LiDAR and time. A plane that is seen for long
// is several (time_windows.h).
struct PlaneAssociation {
  std::vector<MapPlane> planes;
  std::vector<PlaneObservation> observations;
  std::vector<std::size_t> begin;  // of each plane's observations; one more than planes
};

// A observation of a point landmark.
struct LandmarkObservation {
  std::int32_t camera;
  float sigma;  // px, of each coordinate of shape * error
  double time;  // of the image, camera clock
  Eigen::Vector2d pixel;
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();  // errors that are not alike in all directions
};

// A point landmark as a LiDAR measured it: a place of the map that a camera found again. It ties the camera
// to the LiDAR at the beam's time.
struct LidarPointObservation {
  std::int32_t lidar = -1;                             // -1: none
  double time = 0.0;                                   // LiDAR clock
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // LiDAR frame
  float sigma_along = 0.0f;                            // m, along the beam
  float sigma_across = 0.0f;                           // m
};

// A point that cameras see. The anchor, a place near the cameras, is where its bearing and inverse distance
// are taken from as parameters, so that far points are well-behaved. Map frame.
struct PointLandmark {
  Eigen::Vector3d position;
  Eigen::Vector3d anchor;
};

// One drive's point landmarks and the observations of each.
struct LandmarkSet {
  std::vector<PointLandmark> points;
  std::vector<LandmarkObservation> observations;
  std::vector<std::size_t> begin;                   // of each point's observations; one more than points
  std::vector<LidarPointObservation> lidar_points;  // of each point; empty: of none

  bool IsOnMap(std::size_t point) const { return !lidar_points.empty() && lidar_points[point].lidar >= 0; }
};

// Which parameters of a camera do not move.
struct FixedCameraParameters {
  bool rotation = false;
  bool translation = false;
  bool time_offset = false;
  bool readout = false;
  std::vector<bool> intrinsics;  // for each parameter; empty: all move
  bool square_pixels = false;    // both focal lengths move, and a prior has them alike
};

// A pose of the IMU that the trajectory is drawn to while it is being initialised.
struct PoseObservation {
  double time;  // IMU clock
  RigidTransform T_map_imu;
  double sigma_rotation;     // rad
  double sigma_translation;  // m
};

// Everything that the joint solve is made of. What is held constant is said by the flags and the mask.
struct JointProblem {
  const Dataset* dataset = nullptr;
  std::vector<ImuSigma> imu_sigma;                            // for each drive
  std::vector<PlaneAssociation> planes;                       // for each drive; may be empty
  std::vector<LandmarkSet> landmarks;                         // for each drive; may be empty
  std::vector<std::vector<PoseObservation>> poses;            // for each drive; may be empty
  std::vector<std::optional<ExtrinsicGuess>> guesses;         // for each LiDAR: priors
  std::vector<bool> lidar_fixed;                              // neither pose nor offset moves
  std::vector<std::optional<ExtrinsicGuess>> camera_guesses;  // for each camera: priors; may be empty
  std::vector<FixedCameraParameters> camera_fixed;            // for each camera; empty: all move
  bool fix_trajectory = false;                                // and the biases
  bool estimate_imu_matrices = false;
};

struct SolveSummary {
  int iterations = 0;
  double first_cost = 0.0;
  double last_cost = 0.0;
  std::size_t observations = 0;  // of points to planes
  std::size_t landmark_observations = 0;
  double last_step = 0.0;       // largest step of the calibration in the last iteration: m, rad
  Eigen::MatrixXd information;  // of the calibration, from the data alone, at the last linearisation
  // As the solve moved them, for each drive.
  std::vector<std::vector<MapPlane>> planes;
  std::vector<std::vector<PointLandmark>> points;
};

// Gauss-Newton with Marquardt damping on steps that do not lower the cost: at most so many iterations, and no
// more once a step lowers the cost by next to nothing. The result does not depend on the number of threads
// but for the rounding of the dense factorisation.
SolveSummary SolveJointProblem(const JointProblem& problem, int iterations,
                               const CancellationToken& cancellation, CalibrationState* state);

// The prior's information and gradient at the state, calibration parameters only.
void CalibrationPrior(const JointProblem& problem, const CalibrationState& state, const Layout& layout,
                      Eigen::MatrixXd* information, Eigen::VectorXd* gradient);

// IMU residuals of one drive, six for each sample within the trajectory (rad/s, m/s^2), with the samples'
// times.
struct ImuResiduals {
  std::vector<double> times;
  std::vector<Eigen::Matrix<double, 6, 1>> values;
};
ImuResiduals EvaluateImuResiduals(const Dataset& dataset, const CalibrationState& state, std::size_t drive);

// Reprojection errors in pixels of all observations of one drive's landmarks, in their order; not a number
// where the point cannot be projected.
std::vector<Eigen::Vector2d> LandmarkResiduals(const LandmarkSet& landmarks, const CalibrationState& state,
                                               std::size_t drive);

// Signed distances in metres of all observations of one drive to their planes, in their order.
std::vector<float> PlaneResiduals(const PlaneAssociation& association, const CalibrationState& state,
                                  std::size_t drive);

}  // namespace mlic
