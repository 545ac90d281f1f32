#include "mlic_core/initialization/camera_imu/camera_imu.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/imu/excitation.h"
#include "mlic_core/initialization/camera_imu/positions.h"
#include "mlic_core/initialization/camera_imu/rotations.h"
#include "mlic_core/initialization/camera_imu/trajectory.h"
#include "mlic_core/initialization/knot_spacing.h"
#include "mlic_core/problem/priors.h"

namespace mlic {
namespace {

constexpr double kLargestScaleSigma = 0.05;  // relative; from: definition, docs/method.md section 7.6
// from: guard, longer than the lever arms of a rig.
constexpr double kNoGuessSigma = 2.0;  // m, of a lever arm
constexpr double kMeasured = 0.2;      // m, sigma of a guess that someone measured; from: definition
// from: measured, trials, camera and IMU, open 1 and 4: halved and doubled, together with the constants of
// trajectory.cc and position_problem.cc, results change by at most 0.01 sigma.
constexpr double kPart = 15.0;     // s, of a drive that is solved first
constexpr double kPartStep = 5.0;  // s; from: guard, time

constexpr const char* kTurnsTooLittle =
    "the drive turns too little to show time offset and rotation; record one with turns (by hand: about all "
    "axes)";

bool NoneOf(const std::vector<bool>& found) {
  return std::find(found.begin(), found.end(), true) == found.end();
}

void SetImuSigma(const Rig& rig, const Dataset& dataset, Initialization* result) {
  for (const Drive& drive : dataset.drives) {
    result->imu_sigma.push_back(SampleSigma(drive.imu, rig.imu.noise));
  }
}

KnownRotations Known(const Rig& rig, const Dataset& dataset, const std::vector<CameraStart>& start,
                     const std::vector<TrackSet>& tracks, const std::vector<ImuSigma>& imu_sigma,
                     const std::vector<KnotSpacing>& spacing, const VisualRotations& rotations) {
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
  known.least_sigma = 2.0;
  for (const CameraStart& camera : start) {
    if (camera.from_field_of_view) known.least_sigma = 8.0;
  }
  for (const CameraConfig& camera : rig.cameras) {
    ExtrinsicGuess none;
    none.sigma_translation.setConstant(kNoGuessSigma);
    known.guesses.push_back(camera.guess.value_or(none));
    // Rotations and offsets that are still off turn the forces, and by that move a lever arm, to the metre in
    // a car: one that was measured stays until all moves together.
    if (camera.fixed || known.guesses.back().sigma_translation.maxCoeff() <= kMeasured) {
      known.guesses.back().sigma_translation.setConstant(1e-4);
    }
  }
  return known;
}

// Of the drives' time; smooth straight travel at constant speed looks the same to an IMU.
double ShareAtRest(const Rig& rig, const Dataset& dataset) {
  double rest = 0.0, all = 1e-9;
  for (const Drive& drive : dataset.drives) {
    const ImuNoise noise = rig.imu.noise ? *rig.imu.noise : EstimateImuNoise(drive.imu);
    for (const TimeInterval& interval : StaticIntervals(drive.imu, noise)) rest += interval.Duration();
    all += drive.imu.back().time - drive.imu.front().time;
  }
  return rest / all;
}

// Whether turns tell the time offset of any camera. If not, the scale may seem to be shown with an offset
// that is as good as any.
bool OffsetShown(const VisualRotations& rotations) {
  constexpr double kLargestOffsetSigma = 0.2;  // s; from: guard, far within the search of +-1 s
  for (std::size_t c = 0; c < rotations.found.size(); ++c) {
    if (rotations.found[c] && rotations.offset_sigmas[c] < kLargestOffsetSigma) return true;
  }
  return false;
}

bool ScaleShown(const Rig& rig, const Dataset& dataset, const VisualPositions& positions,
                Initialization* result) {
  if (!positions.failure.empty()) {
    result->problems.push_back(positions.failure);
    return false;
  }
  char line[240];
  std::snprintf(
      line, sizeof(line),
      "scale from the accelerometer to %.2f %%, %.0f %% of the observations agree, forces to %.3f m/s^2",
      100.0 * positions.scale_sigma, 100.0 * positions.inlier_share, positions.accelerometer_rms);
  result->notes.push_back(line);
  if (positions.scale_sigma < kLargestScaleSigma) return true;
  const double at_rest = ShareAtRest(rig, dataset);
  if (at_rest > 0.5) {
    std::snprintf(line, sizeof(line), "the rig stands still or moves evenly for %.0f %% of the drive",
                  100.0 * at_rest);
  } else {
    std::snprintf(line, sizeof(line), "the accelerometer tells it to %.0f %% only",
                  100.0 * std::min(10.0, positions.scale_sigma));
  }
  result->problems.push_back("the scale is not shown: " + std::string(line) +
                             "; move with changing speed and direction, or add a LiDAR");
  return false;
}

// Rotations, positions, trajectories and rounds of solving, from the intrinsics given.
Initialization Solve(const Rig& rig, const Dataset& dataset, const std::vector<CameraStart>& start,
                     const std::vector<TrackSet>& tracks, const AdjustmentRounds& rounds,
                     const CancellationToken& cancellation, CameraInitialization* cameras) {
  Initialization result;
  SetImuSigma(rig, dataset, &result);
  const VisualRotations rotations = AlignWithGyroscope(rig, dataset, start, tracks, cancellation);
  result.notes = rotations.notes;
  cameras->found = rotations.found;
  cameras->problems = rotations.problems;
  if (NoneOf(rotations.found)) {
    result.problems.push_back("no camera's images turn as the IMU does: " + std::string(kTurnsTooLittle));
    return result;
  }
  std::vector<KnotSpacing> spacing;
  for (const Drive& drive : dataset.drives) spacing.push_back(ChooseKnotSpacing(drive.imu));
  const KnownRotations known = Known(rig, dataset, start, tracks, result.imu_sigma, spacing, rotations);
  const VisualPositions positions = SolvePositions(known, cancellation);
  if (!ScaleShown(rig, dataset, positions, &result)) {
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      if (!rotations.found[c] || !rotations.open[c]) continue;
      result.problems.push_back(
          rig.cameras[c].name +
          ": the drive turns about one axis only, or hardly, which does not show how the camera is "
          "turned about it; give its T_imu_sensor in the rig file");
    }
    return result;
  }
  if (!OffsetShown(rotations)) {
    result.problems.push_back(kTurnsTooLittle);
    return result;
  }
  CalibrationState& state = result.state;
  if (rig.imu.gravity) state.gravity = *rig.imu.gravity;
  state.cameras = rotations.cameras;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (!rotations.found[c] || rig.cameras[c].fixed) continue;
    state.cameras[c].sensor.T_imu_sensor.translation = positions.lever_arms[c];
  }
  for (std::size_t d = 0; d < dataset.drives.size(); ++d) {
    state.drives.push_back(UprightTrajectory(dataset.drives[d], known.gyro[d], rotations.gyroscope_bias[d],
                                             positions.drives[d], spacing[d], result.imu_sigma[d]));
  }
  CameraAdjustment adjustment;
  adjustment.problem.dataset = &dataset;
  adjustment.problem.imu = FreedomOf(rig.imu);
  // Far from the solution a wrong offset or lever arm looks like a lag of the accelerometer, and beyond the
  // time in which the rig's motion changes no gradient leads back.
  adjustment.problem.imu.lag_sigma = 0.0;
  for (const ImuSigma& sigma : result.imu_sigma) adjustment.problem.drives.emplace_back().imu_sigma = {sigma};
  adjustment.rounds = rounds;
  AdjustCameras(rig, start, tracks, std::move(adjustment), cancellation, &state, cameras);
  cameras->cameras = state.cameras;
  return result;
}

// A part of the first drive that moves a lot, for all but the last solve: what is not known yet, above all
// the gyroscope's bias, bends a short trajectory less than a long one.
struct Part {
  Dataset dataset;
  std::vector<TrackSet> tracks;
};

double StrongestStart(const std::vector<ImuSample>& imu) {
  double best = 0.0, best_start = imu.front().time;
  for (double start = best_start; start + kPart <= imu.back().time; start += kPartStep) {
    std::vector<ImuSample> samples;
    for (const ImuSample& sample : imu) {
      if (sample.time >= start && sample.time < start + kPart) samples.push_back(sample);
    }
    if (samples.size() < 100) continue;
    const Excitation excitation = MeasureExcitation(samples);
    const double strength = excitation.angular_velocity_rms.norm() * excitation.specific_force_rms.norm();
    if (strength <= best) continue;
    best = strength;
    best_start = start;
  }
  return best_start;
}

Part StrongestPart(const Dataset& dataset, const std::vector<TrackSet>& tracks) {
  const std::vector<ImuSample>& imu = dataset.drives[0].imu;
  const double start = StrongestStart(imu), end = start + kPart;
  // from: definition, offsets up to 1 s and a little.
  constexpr double kLargestOffset = 1.1;  // s, of a camera's clock, and some
  Part part;
  part.dataset.drives.emplace_back();
  part.dataset.drives[0].epoch = dataset.drives[0].epoch;
  for (const ImuSample& sample : imu) {
    if (sample.time >= start - kLargestOffset && sample.time <= end + kLargestOffset) {
      part.dataset.drives[0].imu.push_back(sample);
    }
  }
  part.tracks.push_back({tracks[0].keyframes, {}});
  for (const Track& track : tracks[0].tracks) {
    Track cut;
    for (const TrackObservation& seen : track.observations) {
      const double time = tracks[0].keyframes[seen.keyframe].time;
      if (time >= start && time <= end) cut.observations.push_back(seen);
    }
    if (cut.observations.size() >= 2) part.tracks[0].tracks.push_back(std::move(cut));
  }
  return part;
}

// Intrinsics from a part of the drive, for cameras that only have a field of view. Left as they are where
// that does not work out.
std::vector<CameraStart> IntrinsicsOfPart(const Rig& rig, const Dataset& dataset,
                                          std::vector<CameraStart> start, const std::vector<TrackSet>& tracks,
                                          const CancellationToken& cancellation) {
  const Part part = StrongestPart(dataset, tracks);
  CameraInitialization cameras;
  constexpr AdjustmentRounds kPlannedOnly{0, 5};
  const Initialization result =
      Solve(rig, part.dataset, start, part.tracks, kPlannedOnly, cancellation, &cameras);
  if (result.state.drives.empty()) return start;
  JudgeCameras(rig, &cameras);
  for (std::size_t c = 0; c < start.size(); ++c) {
    if (cameras.found[c]) start[c] = {cameras.cameras[c].intrinsics, false};
  }
  return start;
}

}  // namespace

Initialization InitializeFromCameras(const Rig& rig, const Dataset& dataset,
                                     const std::vector<CameraStart>& given,
                                     const std::vector<TrackSet>& tracks,
                                     const CancellationToken& cancellation, CameraInitialization* cameras) {
  std::vector<CameraStart> start = given;
  const bool rough = std::any_of(start.begin(), start.end(),
                                 [](const CameraStart& camera) { return camera.from_field_of_view; });
  if (rough) start = IntrinsicsOfPart(rig, dataset, std::move(start), tracks, cancellation);
  CameraInitialization adjusted;
  Initialization result = Solve(rig, dataset, start, tracks, {2, 8}, cancellation, &adjusted);
  if (result.state.drives.empty()) {
    cameras->found = adjusted.found;
    cameras->problems = adjusted.problems;
    return result;
  }
  JudgeCameras(rig, &adjusted);
  result.notes.insert(result.notes.end(), adjusted.notes.begin(), adjusted.notes.end());
  if (NoneOf(adjusted.found)) {
    result.state.drives.clear();
    result.problems.push_back(
        "no camera's points agree with the IMU; check model and field of view of each camera, or give its "
        "intrinsics");
  }
  *cameras = std::move(adjusted);
  return result;
}

}  // namespace mlic
