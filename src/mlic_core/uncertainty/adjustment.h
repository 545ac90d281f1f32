#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mlic_core/association/match_noise.h"
#include "mlic_core/association/point_landmarks.h"
#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/lidar/plane_map.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/stamp_course.h"
#include "mlic_core/uncertainty/camera_covariance.h"
#include "mlic_core/uncertainty/imu_noise.h"
#include "mlic_core/uncertainty/observability.h"
#include "mlic_core/uncertainty/stamp_errors.h"

namespace mlic {

// Which landmarks take part in a joint adjustment beside the LiDARs' planes: none, points of image tracks, or
// these and places of the LiDAR map found in photos.
enum class Landmarks { kNone, kTracks, kTracksAndMap };

// The cameras of an adjustment. Empty until they join it.
struct AdjustedCameras {
  std::vector<bool> found;                          // of each camera: it takes part
  std::vector<TrackSet> tracks;                     // of each drive
  std::vector<FixedCameraParameters> always_fixed;  // of each camera: given, or not found
  // Of each drive, of each camera: by what its stamps were moved in `tracks` to become those of the
  // landmarks. Empty before.
  std::vector<std::vector<StampCourse>> stamp_courses;
  // Of each camera with a lens that projects alike in another place: by how much its intrinsics are unsure of
  // which place it is. Empty: none.
  std::vector<std::vector<double>> twins;
  LandmarkOptions landmark_options;  // its noise is that of the last round
  std::vector<PoseSigma> sigmas;     // of each camera against the base LiDAR, last solve
};

// What the photos' matches with the LiDAR map add. Empty before Landmarks::kTracksAndMap.
struct MapMatching {
  std::vector<CameraCalibration> cameras_before;  // the cameras when the first photos were matched
  std::vector<MatchNoise> noise;                  // of each camera
  std::vector<LandmarkSet> held_out;              // of each drive: matches that no solve uses
  std::vector<HeldOutMatches> held_out_errors;    // of each camera, once the calibration is settled
};

// How far the rounds of association and solve have come.
struct JointRounds {
  Landmarks landmarks = Landmarks::kNone;  // with which `done` counts
  int done = 0;
  // Rounds done when one last moved the calibration by its sigma, or a review freed or corrected something.
  int last_move = 0;
  // Points that a map of these rounds tied to planes at most, and rounds done when that last grew clearly.
  std::size_t most_points = 0;
  int last_growth = 0;
  int landmark_rounds = 0;          // of those, find landmarks anew
  std::size_t points_per_scan = 0;  // that take part in the map
  bool clocks_freed = false;        // the sensors' clocks may drift
  bool stamps_settled = false;      // the courses of cameras' stamps move no more
  bool matrices_judged = false;     // whether the IMU has errors of scale and shear
  bool biases_judged = false;       // whether the IMU's biases wander
  bool noise_measured = false;      // Adjustment::noise_information is of these rounds
  bool ranges_measured = false;     // whether LiDARs' ranges err together (CorrectRanges)
  bool walks_dropped = false;       // walks of LiDARs grew beyond what these err by, and count as none
  // By how many of its sigmas the last round moved the calibration where rounds were over before it was
  // settled, else 0: part of the sigmas.
  double unsettled = 0.0;
  double last_change = 0.0;           // by how many of its sigmas the last round moved the calibration
  std::vector<RoundSummary> history;  // all rounds until now, those with other landmarks too
};

// By what the last solve's information is too good, measured once the calibration is settled.
struct CovarianceScale {
  double correlation = 1.0;  // of variances, for errors that points share
  Inflation inflation;
  std::vector<StampErrors> stamps;  // of each LiDAR, then of each camera; empty before
  std::vector<double> offsets;      // m, of each LiDAR's ranges (ApparentOffsets); empty before
  // Of each drive, empty before; the last solve's sigmas of the IMU contain it already.
  std::vector<ImuMeanExcess> imu;
};

// A calibration while it is adjusted: what the rounds keep, what a checkpoint holds (serialize_stages.cc says
// which part of it), and what summary/ makes the result from.
struct Adjustment {
  CalibrationState state;
  CalibrationState initial;  // the sensors as the initialisation left them; without drives
  std::size_t base_lidar = 0;
  std::vector<bool> unaligned_lidars, loose_lidars;  // of each LiDAR: see Initialization
  // Of each LiDAR: takes no part, as it is loose or its planes lead far from its guess.
  std::vector<bool> rejected_lidars;
  // Of each LiDAR, then of each camera: what the data show of it contradicts its guess, which counts no more.
  std::vector<bool> contradicted_guesses;
  JointProblem problem;
  std::vector<ImuSigma> given_imu_sigma;  // of each drive, before residuals were measured
  Eigen::Matrix3d alignment_covariance = Eigen::Matrix3d::Zero();  // AlignmentReview::covariance
  // NoiseInformation at an earlier solve of the same calibration parameters; empty before.
  Eigen::MatrixXd noise_information;
  std::vector<PlaneNoise> plane_noise;  // of each LiDAR
  AdjustedCameras cameras;
  MapMatching map;
  JointRounds rounds;
  SolveSummary last_solve;
  CovarianceScale scale;
  std::vector<SensorHalves> halves;  // CompareHalves, of the settled calibration; empty before
  // What the data show of each sensor, once directions were held for it; empty before, and where all is
  // shown.
  std::vector<ObservabilityAnalysis::Sensor> shown_before_hold;
  std::vector<std::string> lines;  // what the present stage has reported so far
};

// Of the last solve's whitened residuals: one where they are as large as their noise.
double MeanSquaredResidual(const Adjustment& adjustment, const Dataset& dataset);

// Mean square over the drives of the courses that a camera's stamps were found to follow, s^2; zero: none.
double StampWander(const Adjustment& adjustment, std::size_t camera);

// By how much variances exceed those of the last solve's information: the mean squared residual where that is
// above one, the points' correlation, and what rounds still differ by.
double VarianceScale(const Adjustment& adjustment, const Dataset& dataset);

// The last solve's information of the calibration; zero where only damped steps had a solution.
Eigen::MatrixXd LastInformation(const Adjustment& adjustment);

// The last solve's information of the calibration without what of it is the noise's, divided by the
// VarianceScale.
Eigen::MatrixXd ScaledInformation(const Adjustment& adjustment, const Dataset& dataset);

// What the data show at the last linearisation, with sigmas that grow by the VarianceScale and, for cameras,
// by camera_covariance.h. The offsets of cameras whose stamps drift faster than crystals (kFastestCrystals)
// or wander are as unsure as they move in the drive. Once parts of the drive were compared, sigmas grow by
// what these differ by (GrowthOfSigmas).
ObservabilityAnalysis Analyze(const Adjustment& adjustment, const Dataset& dataset);

// The same from the measured noise alone, taken for white, with nothing that covariances grow by: the
// Cramer-Rao bound of the model, which no unbiased estimate of these data is better than.
ObservabilityAnalysis AnalyzeBound(const Adjustment& adjustment);

// Largest change of a sensor since `before`, in sigmas of the last solve; very large where there was none or
// a sigma is not a number.
double ChangeInSigmas(const Adjustment& adjustment, const Dataset& dataset, const CalibrationState& before);

}  // namespace mlic
