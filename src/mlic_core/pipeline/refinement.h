#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mlic_core/association/map_matches.h"
#include "mlic_core/association/plane_association.h"
#include "mlic_core/association/point_landmarks.h"
#include "mlic_core/initialization/camera_on_trajectory.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/pipeline/stage_store.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/uncertainty/observability.h"
#include "mlic_core/uncertainty/stamp_errors.h"

namespace mlic {

// SPEC stage 6: association and solve in turn until the calibration stands still. Holds the state while it is
// refined.
class Refinement {
 public:
  using Progress = std::function<void(double)>;
  using Line = std::function<void(const std::string&)>;

  // rig and dataset must outlive this.
  Refinement(const Rig& rig, const Dataset& dataset, Initialization start,
             const CancellationToken& cancellation, CalibrationObserver& observer);

  // Stage 6a: each LiDAR on planes of its own. The base LiDAR's refines the trajectory, the others' hold it.
  void AdjustEachLidar(const Progress& progress, const Line& line);

  // The cameras found join with their tracks (of each drive): from here on AdjustJointly moves them too.
  void AddCameras(const CameraInitialization& cameras, const std::vector<TrackSet>& tracks);

  // Stages 6b and 6c: one map of all LiDARs and all landmarks, everything moves. until: what of its sigma the
  // calibration may still move by in the last round. Calls after_round when another round follows.
  void AdjustJointly(
      double until, const Progress& progress, const Line& line,
      const std::function<void()>& after_round = [] {});

  // After AdjustEachLidar: from here on, LiDARs that were not aligned and whose planes lead far from their
  // guess (guess_check.h) take no part.
  void RejectLostLidars(const Line& line);

  // From here on AdjustJointly also matches the cameras' photos to the LiDAR map (SPEC stages 7 and 8).
  void MatchMap();

  // How well the map fits the photos where no solve looked; tells `line` of each camera.
  void MeasureHeldOut(const Line& line);

  // Of the points, of the times of LiDARs' scans and of cameras' observations, once the calibration stands
  // still: sigmas grow by it.
  void MeasureCorrelation(const Line& line);

  // What to keep between rounds, and how to go on from it.
  RefinementProgress Checkpoint() const;
  void Restore(const RefinementProgress& progress);

  const CalibrationState& state() const { return state_; }
  // The sensors as the initialisation left them; without drives.
  const CalibrationState& initial() const { return initial_; }
  const JointProblem& problem() const { return problem_; }
  const std::vector<PlaneNoise>& noise() const { return noise_; }
  const SolveSummary& last_solve() const { return last_solve_; }
  // Of each LiDAR: see Initialization.
  const std::vector<bool>& unaligned_lidars() const { return unaligned_lidars_; }
  // Of each LiDAR, from RejectLostLidars.
  const std::vector<bool>& rejected_lidars() const { return rejected_lidars_; }
  // By how many of its sigmas the last round moved the calibration where rounds were over before it stood
  // still, else 0: part of the sigmas.
  double unsettled() const { return unsettled_; }
  const std::vector<bool>& cameras_found() const { return cameras_found_; }
  bool matched_map() const { return match_map_; }
  // Of each camera, from MeasureHeldOut; empty before.
  const std::vector<HeldOutMatches>& held_out_errors() const { return held_out_errors_; }
  // Of each LiDAR, then of each camera, from MeasureCorrelation; empty before.
  const std::vector<StampErrors>& stamp_errors() const { return stamp_errors_; }
  // The cameras when MatchMap was called.
  const std::vector<CameraCalibration>& cameras_before_map() const { return cameras_before_map_; }

  // What the data show at the last linearisation. Sigmas grow by the square root of the mean squared whitened
  // residual where that is above one, of the points' correlation, by what rounds still differ by, and what
  // cameras say by camera_covariance.h.
  ObservabilityAnalysis Analyze() const;

 private:
  void Associate(const std::vector<bool>& lidars, std::size_t points_per_scan);
  void AssociateLandmarks(const Progress& progress, const Line& line);
  void FixUnobservable();
  // True if the next round takes more points of each scan.
  bool TakeMorePoints();
  // Solves from the state as it is: state and landmarks move together.
  SolveSummary Solve(int iterations);
  void MeasureImuSigma();
  // By how much variances exceed those of the last solve's information.
  double VarianceScale() const;
  Eigen::MatrixXd ScaledInformation() const;
  // Largest change of a sensor since `before`, in sigmas of the last solve.
  double ChangeInSigmas(const CalibrationState& before) const;
  void Show(const std::string& stage, int iteration);

  const Rig& rig_;
  const Dataset& dataset_;
  const CancellationToken& cancellation_;
  CalibrationObserver& observer_;
  std::size_t base_lidar_;
  std::vector<bool> unaligned_lidars_, rejected_lidars_;
  CalibrationState state_, initial_;
  JointProblem problem_;
  std::vector<ImuSigma> given_imu_sigma_;
  std::vector<PlaneNoise> noise_;
  std::vector<TrackSet> tracks_;                     // of each drive; empty without cameras
  std::vector<FixedCameraParameters> always_fixed_;  // of each camera
  LandmarkOptions landmark_options_;
  std::vector<bool> cameras_found_;
  bool match_map_ = false;
  std::vector<CameraCalibration> cameras_before_map_;
  std::vector<double> match_noise_;    // of each camera: of the sigmas that matches claim
  std::vector<LandmarkSet> held_out_;  // of each drive: matches that no solve uses
  std::vector<HeldOutMatches> held_out_errors_;
  std::vector<PoseSigma> sigmas_;  // of each camera against the base LiDAR, of the last solve
  int rounds_ = 0;                 // of the joint adjustment, done
  std::size_t points_per_scan_;
  SolveSummary last_solve_;
  double correlation_ = 1.0;  // of the points, measured once the calibration stands still
  CameraDoubt camera_doubt_;  // likewise
  std::vector<StampErrors> stamp_errors_;
  double unsettled_ = 0.0;
};

}  // namespace mlic
