#include "mlic_core/calibration/visual_initialization.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/calibration/knot_spacing.h"
#include "mlic_core/calibration/visual_initialization_positions.h"
#include "mlic_core/calibration/visual_initialization_rotations.h"
#include "mlic_core/calibration/visual_initialization_trajectory.h"
#include "mlic_core/imu/excitation.h"

namespace mlic {
namespace {

constexpr double kLargestScaleSigma = 0.05;  // relative
constexpr double kNoGuessSigma = 2.0;        // m, of a lever arm

void SetImuSigma(const Rig& rig, const Dataset& dataset, Initialization* result) {
  for (const Drive& drive : dataset.drives) {
    ImuNoise noise = EstimateImuNoise(drive.imu);
    if (rig.imu.noise) noise = *rig.imu.noise;
    const double root_rate = std::sqrt(ImuRate(drive.imu));
    result->imu_sigma.push_back({noise.gyroscope * root_rate, noise.accelerometer * root_rate});
  }
}

KnownRotations Known(const Rig& rig, const Dataset& dataset, const std::vector<TrackSet>& tracks,
                     const std::vector<ImuSigma>& imu_sigma, const std::vector<KnotSpacing>& spacing,
                     const VisualRotations& rotations) {
  KnownRotations known;
  known.dataset = &dataset;
  known.tracks = &tracks;
  known.imu_sigma = imu_sigma;
  known.cameras = rotations.cameras;
  known.found = rotations.found;
  for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
    known.gyro.emplace_back(dataset.drives[d].imu, rotations.gyroscope_bias[d]);
    known.knot_spacing.push_back(spacing[d].position);
  }
  for (const CameraConfig& camera : rig.cameras) {
    ExtrinsicGuess none;
    none.sigma_translation.setConstant(kNoGuessSigma);
    known.guesses.push_back(camera.guess.value_or(none));
    if (camera.fixed) known.guesses.back().sigma_translation.setConstant(1e-4);
  }
  return known;
}

}  // namespace

Initialization InitializeFromCameras(const Rig& rig, const Dataset& dataset,
                                     const std::vector<CameraStart>& start,
                                     const std::vector<TrackSet>& tracks,
                                     const CancellationToken& cancellation, CameraInitialization* cameras) {
  Initialization result;
  SetImuSigma(rig, dataset, &result);
  const VisualRotations rotations = AlignWithGyroscope(rig, dataset, start, tracks, cancellation);
  result.notes = rotations.notes;
  result.problems = rotations.problems;
  if (std::none_of(rotations.found.begin(), rotations.found.end(), [](bool found) { return found; })) {
    result.problems.push_back(
        "no camera's images turn as the IMU does: the drive turns too little to show time offset and "
        "rotation; "
        "record one with turns (by hand: about all axes)");
    return result;
  }
  std::vector<KnotSpacing> spacing;
  for (const Drive& drive : dataset.drives) spacing.push_back(ChooseKnotSpacing(drive.imu));
  const KnownRotations known = Known(rig, dataset, tracks, result.imu_sigma, spacing, rotations);
  const VisualPositions positions = SolvePositions(known, cancellation);
  if (!positions.failure.empty()) {
    result.problems.push_back(positions.failure);
    return result;
  }
  char line[240];
  std::snprintf(line, sizeof(line),
                "scale from the accelerometer to %.2f %%, %.0f %% of the sights agree, forces to %.3f m/s^2",
                100.0 * positions.scale_sigma, 100.0 * positions.inlier_share, positions.accelerometer_rms);
  result.notes.push_back(line);
  if (!(positions.scale_sigma < kLargestScaleSigma)) {
    std::snprintf(
        line, sizeof(line),
        "the scale is not shown: the accelerometer tells it to %.0f %% only; move with changing speed "
        "and direction, or add a LiDAR",
        100.0 * std::min(10.0, positions.scale_sigma));
    result.problems.push_back(line);
    return result;
  }
  CalibrationState state;
  state.cameras = rotations.cameras;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (!rotations.found[c] || rig.cameras[c].fixed) continue;
    state.cameras[c].sensor.T_imu_sensor.translation = positions.lever_arms[c];
  }
  for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
    state.drives.push_back(UprightTrajectory(dataset.drives[d], known.gyro[d], rotations.gyroscope_bias[d],
                                             positions.drives[d], spacing[d], result.imu_sigma[d]));
  }
  JointProblem problem;
  problem.dataset = &dataset;
  problem.imu_sigma = result.imu_sigma;
  CameraInitialization adjusted;
  adjusted.found = rotations.found;
  AdjustCameras(rig, start, tracks, std::move(problem), cancellation, &state, &adjusted);
  adjusted.cameras = state.cameras;
  JudgeCameras(rig, &adjusted);
  adjusted.notes.insert(adjusted.notes.begin(), rotations.notes.begin(), rotations.notes.end());
  result.notes.insert(result.notes.end(), adjusted.notes.begin(), adjusted.notes.end());
  result.problems.insert(result.problems.end(), adjusted.problems.begin(), adjusted.problems.end());
  result.state = std::move(state);
  if (cameras) *cameras = std::move(adjusted);
  return result;
}

}  // namespace mlic
