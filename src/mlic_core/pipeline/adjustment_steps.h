#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/initialization/camera_on_trajectory.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/linearized_problem.h"
#include "mlic_core/result/observer.h"
#include "mlic_core/uncertainty/adjustment.h"

namespace mlic {

// What the steps of an adjustment work on, and whom they report to.
struct AdjustmentContext {
  const Rig& rig;
  const Dataset& dataset;
  CalibrationObserver& observer;
  Monitor monitor;
  const FeatureMatcher* features = nullptr;  // that finds the map in photos; null: its structure does
};

// Of each scan. The first rounds find the map with few points; the last ones measure with many. from: guard,
// time.
constexpr std::size_t kFewPoints = 800;

// Of Gauss-Newton in each round: a stretch of trajectory that starts beside the map comes back in several.
// from: guard, the solve ends by convergence
constexpr int kSolverIterations = 6;

// The initialisation's state with all LiDARs and no camera; nothing is associated yet. The dataset must
// outlive it.
Adjustment StartAdjustment(const Rig& rig, const Dataset& dataset, Initialization start);

// The cameras found join with their tracks (of each drive).
void AddCameras(const Rig& rig, const CameraInitialization& cameras, const std::vector<TrackSet>& tracks,
                Adjustment* adjustment);

// In the rig file.
const std::string& NameOf(SensorId sensor, const Rig& rig);

// Ties points of the LiDARs that take part to planes of a map drawn with the state. keep: whether the next
// map keeps to this one's planes where they are at a limit.
void AssociateWithPlanes(const AdjustmentContext& context, const std::vector<bool>& lidars,
                         std::size_t points_per_scan, bool keep, Adjustment* adjustment);

// Solves from the state as it is: state and landmarks move together. probe_matrices: SolveJointProblem's.
// Throws InternalError where the equations have no solution.
SolveSummary SolveAdjustment(const CancellationToken& cancellation, Adjustment* adjustment,
                             bool probe_matrices = false);

// What of MeasureScale needs no linearised problem: correlation and stamps.
void MeasureCorrelation(const Adjustment& adjustment, CovarianceScale* scale);

// By what the last solve's information is too good, but for the IMU's part. linearized: the adjustment's
// problem at its state.
void MeasureScale(const LinearizedProblem& linearized, const Adjustment& adjustment, CovarianceScale* scale);

// Shows the state to the observer. change: CalibrationSnapshot's.
void ShowAdjustment(const AdjustmentContext& context, const std::string& stage, int iteration,
                    const Adjustment& adjustment, std::optional<double> change = std::nullopt);

}  // namespace mlic
