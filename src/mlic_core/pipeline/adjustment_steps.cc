#include "mlic_core/pipeline/adjustment_steps.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "mlic_core/association/group_errors.h"
#include "mlic_core/association/plane_association.h"
#include "mlic_core/common/error.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/summary/snapshot.h"
#include "mlic_core/uncertainty/point_scatter.h"
#include "mlic_core/uncertainty/range_corrections.h"
#include "mlic_core/uncertainty/stamp_doubt.h"

namespace mlic {
namespace {

// Of an observation of a landmark whose noise is its own, in its sigmas. That noise already makes wrong
// observations count for little. Judged more strictly, observations that agree with the calibration as it
// stands win over those that do not, and its errors grow from round to round. from: measured, paper rig,
// seeds 1 to 3
constexpr double kLargestOwnError = 8.0;

}  // namespace

Adjustment StartAdjustment(const Rig& rig, const Dataset& dataset, Initialization start) {
  Adjustment adjustment;
  adjustment.base_lidar = start.base_lidar;
  adjustment.unaligned_lidars = std::move(start.unaligned);
  adjustment.loose_lidars = std::move(start.loose);
  adjustment.loose_lidars.resize(rig.lidars.size(), false);
  adjustment.rejected_lidars = adjustment.loose_lidars;
  adjustment.contradicted_guesses.assign(rig.lidars.size(), false);
  adjustment.state = std::move(start.state);
  adjustment.initial.lidars = adjustment.state.lidars;
  adjustment.plane_noise.resize(rig.lidars.size());
  adjustment.rounds.points_per_scan = kFewPoints;
  JointProblem& problem = adjustment.problem;
  problem.dataset = &dataset;
  for (const ImuSigma& sigma : start.imu_sigma) problem.drives.emplace_back().imu_sigma = {sigma};
  adjustment.given_imu_sigma = std::move(start.imu_sigma);
  problem.imu = FreedomOf(rig.imu);
  if (rig.imu.gravity) adjustment.state.gravity = *rig.imu.gravity;
  for (const LidarConfig& lidar : rig.lidars) {
    const bool still = lidar.fixed || adjustment.rejected_lidars[problem.lidars.size()];
    problem.lidars.push_back({lidar.fixed ? std::nullopt : lidar.guess, still});
  }
  return adjustment;
}

void AddCameras(const Rig& rig, const CameraInitialization& cameras, const std::vector<TrackSet>& tracks,
                Adjustment* adjustment) {
  CalibrationState& state = adjustment->state;
  AdjustedCameras& adjusted = adjustment->cameras;
  JointProblem& problem = adjustment->problem;
  state.cameras = adjustment->initial.cameras = cameras.cameras;
  adjusted.found = cameras.found;
  adjustment->contradicted_guesses.resize(state.Sensors().size(), false);
  adjusted.tracks = WithoutLostCameras(tracks, cameras.found);
  // The cameras are not yet as right as single observations are sharp: the first round judges less strictly.
  for (const LandmarkNoise& noise : cameras.noise) {
    adjusted.landmark_options.noise.push_back({noise.spread * noise.dependence, 1.0});
  }
  adjusted.landmark_options.noise_of_each = true;
  adjusted.landmark_options.largest_error = kLargestOwnError;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const CameraConfig& config = rig.cameras[c];
    const bool still = config.fixed || !cameras.found[c];
    problem.cameras.push_back(
        {config.fixed ? std::nullopt : config.guess, cameras.held[c], config.intrinsics});
    adjusted.always_fixed.push_back({still, still, still, !cameras.found[c], {}});
    adjusted.always_fixed.back().intrinsics.assign(state.cameras[c].intrinsics.parameters.size(),
                                                   config.intrinsics_fixed || !cameras.found[c]);
  }
}

const std::string& NameOf(SensorId sensor, const Rig& rig) {
  return sensor.IsLidar() ? rig.lidars[sensor.index].name : rig.cameras[sensor.index].name;
}

void AssociateWithPlanes(const AdjustmentContext& context, const std::vector<bool>& lidars,
                         std::size_t points_per_scan, bool keep, Adjustment* adjustment) {
  const Dataset& dataset = context.dataset;
  AssociationOptions options;
  options.root_voxel = RootVoxelSize(dataset.drives[0]);
  options.points_per_scan = points_per_scan;
  options.lidars = lidars;
  std::vector<DriveTerms>& drives = adjustment->problem.drives;
  for (DriveTerms& drive : drives) drive.planes = {};  // the old ones' memory is needed
  for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
    context.monitor.cancellation.ThrowIfCancelled();
    options.last_voxels = std::exchange(drives[d].plane_voxels, {});
    drives[d].planes =
        AssociatePlanes(dataset.drives[d], adjustment->state, d, adjustment->plane_noise, options);
    if (!keep) continue;
    std::vector<std::uint64_t>& voxels = drives[d].plane_voxels;
    for (const MapPlane& plane : drives[d].planes.planes) voxels.push_back(plane.voxel);
    std::sort(voxels.begin(), voxels.end());
    voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
  }
}

SolveSummary SolveAdjustment(const CancellationToken& cancellation, Adjustment* adjustment,
                             bool probe_matrices) {
  JointProblem& problem = adjustment->problem;
  SolveSummary summary =
      SolveJointProblem(problem, kSolverIterations, cancellation, &adjustment->state, probe_matrices);
  if (!summary.solved || !IsFinite(adjustment->state)) {
    throw InternalError(
        "the joint adjustment's equations have no solution in numbers; please report this with the log");
  }
  // Residuals to planes where the solve did not leave them would look like noise.
  PlaceLandmarks(std::move(summary.landmarks), &problem);
  return summary;
}

void MeasureCorrelation(const Adjustment& adjustment, CovarianceScale* scale) {
  const JointProblem& problem = adjustment.problem;
  const CalibrationState& state = adjustment.state;
  scale->correlation = CorrelationFactor(problem.drives, state);
  scale->stamps = MeasureStampErrors(problem, state);
  for (std::size_t l = 0; l < state.lidars.size(); ++l) {
    scale->correlation = std::max(scale->correlation, scale->stamps[l].excess);
  }
}

void MeasureScale(const LinearizedProblem& linearized, const Adjustment& adjustment, CovarianceScale* scale) {
  const JointProblem& problem = adjustment.problem;
  const CalibrationState& state = adjustment.state;
  MeasureCorrelation(adjustment, scale);
  scale->inflation.points = ScatterOfPoints(linearized, scale->correlation);
  scale->inflation.points +=
      ScatterOfRanges(problem, state, scale->correlation, adjustment.rounds.walks_dropped);
  scale->offsets = ApparentOffsets(problem, state, scale->correlation);
  if (adjustment.rounds.landmarks == Landmarks::kNone) return;
  scale->inflation.cameras = MeasureCameraInflation(
      linearized, adjustment.cameras.landmark_options,
      AnalyzeCalibration(problem, state, LastInformation(adjustment)).solved_covariance);
  if (scale->inflation.cameras.IsEmpty()) return;
  scale->inflation.points += ScatterOfStamps(adjustment, scale->correlation);
  // Stamps whose errors last for seconds are too few for their scatter: what they err by, one after the
  // other, is counted.
  const Layout layout(state, problem.estimate_imu_matrices);
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const double least = std::sqrt(scale->stamps[state.lidars.size() + c].excess);
    for (const int at : {layout.Camera(c) + 6, layout.Drift(CameraId(c)), layout.Readout(c)}) {
      if (at >= 0) scale->inflation.cameras.growth[at] = std::max(scale->inflation.cameras.growth[at], least);
    }
  }
}

void ShowAdjustment(const AdjustmentContext& context, const std::string& stage, int iteration,
                    const Adjustment& adjustment, std::optional<double> change) {
  CalibrationSnapshot snapshot = MakeSnapshot(stage, iteration, context.rig, context.dataset, adjustment);
  snapshot.change = change;
  context.observer.OnSnapshot(snapshot);
}

}  // namespace mlic
