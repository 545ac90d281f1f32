#include "mlic_core/initialization/camera_on_trajectory.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/association/landmark_noise.h"
#include "mlic_core/camera/colmap/colmap_camera.h"
#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/initialization/camera_rotation.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/sensors/double_sphere_twin.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"

namespace mlic {
namespace {

constexpr std::size_t kFewestObservations = 200;  // from: definition, docs/method.md section 12

// Of visual rotations that agree with the trajectory's. By chance a few per cent do; with a rough focal
// length and unknown distortion not many more than this.
constexpr double kLeastRotationShare = 0.15;

// px, of a match that agrees with a lens of the unified model, or with a given one. from: measured, halved
// and doubled (camera_rotation.cc).
constexpr double kRoughLensError = 8.0, kLensError = 3.0;

// What one round of triangulation and solve does.
struct Round {
  double least_sigma;  // px; covers what the calibration is still off by
  double least_parallax_deg;
  int parameters;  // that may move beside pose and offset; see FixedInRound
};
constexpr Round kRounds[] = {{8.0, 1.0, 1}, {6.0, 1.0, 2}, {4.0, 1.0, 2}, {2.0, 1.0, 3}, {1.0, 0.5, 3}};
constexpr int kAllParameters = 3;     // from: structural
constexpr double kStandsStill = 0.1;  // of a sigma; from: definition, docs/method.md: settled

// The distortion that images show most: k1, or double_sphere's alpha.
int FirstDistortion(CameraModel model) { return model == CameraModel::kDoubleSphere ? 5 : 4; }

// Holds all but what is meant to move in this round: with 1 the focal lengths that come from a field of view,
// with 2 also their first term of distortion and readouts, with 3 everything.
std::vector<FixedCameraParameters> FixedInRound(const Rig& rig, const std::vector<CameraStart>& start,
                                                const std::vector<bool>& found, int parameters) {
  std::vector<FixedCameraParameters> held(rig.cameras.size());
  for (std::size_t c = 0; c < held.size(); ++c) {
    const bool fixed = rig.cameras[c].fixed || !found[c];
    const bool lens_held = start[c].intrinsics_held || !found[c];
    held[c] = {fixed, fixed, fixed, parameters < 2 || start[c].readout_held || !found[c], {}};
    auto& intrinsics = held[c].intrinsics;
    intrinsics.assign(start[c].intrinsics.parameters.size(), parameters < 3 || lens_held);
    if (lens_held || !start[c].from_field_of_view) continue;
    intrinsics[0] = intrinsics[1] = false;
    if (parameters >= 2) intrinsics[FirstDistortion(start[c].intrinsics.model)] = false;
  }
  return held;
}

// A focal length from no more than a field of view is off by some percent, and all else would follow it if it
// were held there. It moves also where rounds with few observations do not determine it. allowed: what else
// may move.
std::vector<FixedCameraParameters> WithFocalLengths(const Rig& rig,
                                                    const std::vector<FixedCameraParameters>& allowed,
                                                    std::vector<FixedCameraParameters> held) {
  for (std::size_t c = 0; c < held.size(); ++c) {
    if (rig.cameras[c].intrinsics) continue;
    for (const int i : {0, 1}) held[c].intrinsics[i] = allowed[c].intrinsics[i];
  }
  return held;
}

// Largest change of what is not held, in sigmas.
double ChangeInSigmas(const CalibrationState& before, const CalibrationState& after, const Layout& layout,
                      const std::vector<FixedCameraParameters>& held, const Eigen::MatrixXd& information) {
  const Eigen::VectorXd limits = CalibrationLimits(after, layout);
  Eigen::MatrixXd known = InformationWithFixed(information, after, layout, held);
  known.diagonal() += 1e-6 * limits.cwiseAbs2().cwiseInverse();
  const int cameras = layout.poses;
  const Eigen::MatrixXd scaled = limits.asDiagonal() * known * limits.asDiagonal();
  const Eigen::VectorXd sigmas =
      SolveSymmetric(scaled, Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols()))
          .diagonal()
          .cwiseAbs()
          .cwiseSqrt();
  double largest = 0.0;
  for (std::size_t c = 0; c < after.cameras.size(); ++c) {
    const SensorCalibration &a = before.cameras[c].sensor, &b = after.cameras[c].sensor;
    Eigen::Matrix<double, 7, 1> change;
    change << Log(b.T_imu_sensor.rotation * a.T_imu_sensor.rotation.conjugate()),
        b.T_imu_sensor.translation - a.T_imu_sensor.translation, b.time_offset - a.time_offset;
    for (int i = 0; i < 7; ++i) {
      const int at = layout.Camera(c) + i;
      if (at < cameras) largest = std::max(largest, std::abs(change[i]) / (limits[at] * sigmas[at]));
    }
  }
  return largest;
}

// rad, of rays that a lens of this model is fitted to: polynomials in the tangent of the angle grow without
// bounds before 90 deg, and the sixth power of that at 70 deg (400) is what a fit from no distortion bears.
double WidestAngle(CameraModel model) {
  const bool pinhole = model == CameraModel::kPlumbBob || model == CameraModel::kRationalPolynomial;
  return pinhole ? 70.0 * M_PI / 180.0 : M_PI;
}

}  // namespace

std::vector<CameraStart> StartFromRig(const Rig& rig, const Dataset& dataset) {
  std::vector<CameraStart> starts;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const CameraConfig& config = rig.cameras[c];
    int width = 0, height = 0;
    for (const Drive& drive : dataset.drives) {
      if (width > 0 || c >= drive.cameras.size()) continue;
      width = drive.cameras[c].width;
      height = drive.cameras[c].height;
    }
    if (config.intrinsics) {
      starts.push_back({{config.model, width, height, *config.intrinsics}, false});
      starts.back().intrinsics_held = config.intrinsics_fixed;
    } else if (config.fov_deg) {
      starts.push_back({IntrinsicsFromFieldOfView(config.model, width, height, *config.fov_deg), true});
    } else {
      throw InputError(
          "camera '" + config.name +
          "': the rig file gives neither intrinsics nor fov_deg; add the horizontal field of view "
          "in degrees as fov_deg");
    }
  }
  return starts;
}

bool AlignCamera(const CameraConfig& config, const CameraStart& start, const std::vector<PixelMatches>& pairs,
                 const std::vector<const SplitSpline*>& T_map_imu, CameraCalibration* camera,
                 CameraAlignment* alignment) {
  if (start.from_field_of_view) {
    const auto fit =
        SearchLens(pairs, T_map_imu, {start.intrinsics, config.guess, config.time_offset, alignment->lens});
    if (!fit) return false;
    const CameraModel model = start.intrinsics.model;
    camera->intrinsics = fit->at.lens;
    if (model != fit->at.lens.model) {
      camera->intrinsics = FitCameraModel(fit->at.lens, model, WidestAngle(model));
    }
    if (model == CameraModel::kDoubleSphere) {
      constexpr double kUsualXi = -0.2;  // from: standard, published calibrations have -0.17 to -0.27
      const auto usual = DoubleSphereOfXi(camera->intrinsics, kUsualXi);
      if (usual) camera->intrinsics = *usual;
    }
    alignment->lens = fit->at;
  }
  const auto motions =
      VisualMotions(pairs, camera->intrinsics, start.from_field_of_view ? kRoughLensError : kLensError);
  CameraRotation& rotation = alignment->rotation;
  rotation = AlignCameraRotation(motions, T_map_imu, config.guess, config.time_offset);
  if (!rotation.valid || rotation.inlier_share < kLeastRotationShare) return false;
  camera->sensor.T_imu_sensor.rotation = rotation.R_imu_camera;
  camera->sensor.time_offset = rotation.time_offset;
  // Where the motion turns about one axis, the directions of motion say the rest, which FitLens does not use.
  if (alignment->lens && rotation.weakest_axis >= kWeakAxis) {
    camera->sensor.T_imu_sensor.rotation = alignment->lens->R_imu_camera;
    camera->sensor.time_offset = alignment->lens->time_offset;
  }
  return true;
}

std::string AlignmentNote(const std::string& name, const CameraCalibration& camera,
                          const CameraRotation& rotation) {
  char line[200];
  std::snprintf(line, sizeof(line), "%s: offset %.1f ms, focal length %.0f px, turns as the IMU to %.2f deg",
                name.c_str(), 1e3 * rotation.time_offset, camera.intrinsics.parameters[0],
                rotation.residual * 180.0 / M_PI);
  return line;
}

std::string AlignmentProblem(const std::string& name) {
  return name +
         ": its images do not turn as the IMU does (too few matches, a blocked view, or another vehicle's "
         "topic)";
}

CameraCalibration CameraAsGiven(const CameraConfig& config, const CameraStart& start) {
  CameraCalibration camera;
  camera.intrinsics = start.intrinsics;
  camera.rolling_shutter = config.shutter == Shutter::kRolling;
  camera.readout = start.readout;
  if (config.guess) camera.sensor.T_imu_sensor = config.guess->T_imu_sensor;
  camera.sensor.time_offset = config.time_offset.value_or(0.0);
  return camera;
}

void AdjustCameras(const Rig& rig, const std::vector<CameraStart>& start,
                   const std::vector<TrackSet>& all_tracks, CameraAdjustment adjustment,
                   const CancellationToken& cancellation, CalibrationState* state,
                   CameraInitialization* result) {
  JointProblem& problem = adjustment.problem;
  const std::size_t cameras = rig.cameras.size();
  const std::vector<TrackSet> tracks = WithoutLostCameras(all_tracks, result->found);
  problem.drives.resize(state->drives.size());
  problem.cameras.resize(cameras);
  for (std::size_t c = 0; c < cameras; ++c) {
    problem.cameras[c].guess = rig.cameras[c].fixed ? std::nullopt : rig.cameras[c].guess;
    problem.cameras[c].given_intrinsics = rig.cameras[c].intrinsics;
  }
  LandmarkOptions options;
  options.noise.assign(cameras, LandmarkNoise());
  std::vector<FixedCameraParameters>& held = result->held;
  const auto hold = [&](std::vector<FixedCameraParameters> now) {
    held = std::move(now);
    for (std::size_t c = 0; c < cameras; ++c) problem.cameras[c].fixed = held[c];
  };
  const Layout layout(*state, false);
  constexpr int kPlanned = static_cast<int>(std::size(kRounds));  // from: structural
  for (int round = adjustment.rounds.first; round < adjustment.rounds.end; ++round) {
    cancellation.ThrowIfCancelled();
    const bool planned = round < kPlanned;
    options.least_sigma = planned ? kRounds[round].least_sigma : 0.0;
    options.least_parallax_deg =
        planned ? kRounds[round].least_parallax_deg : LandmarkOptions().least_parallax_deg;
    for (std::size_t d = 0; d < tracks.size(); ++d) {
      problem.drives[d].landmarks = TriangulateLandmarks(tracks[d], *state, d, options);
    }
    const CalibrationState before = *state;
    const int parameters = planned ? kRounds[round].parameters : kAllParameters;
    hold(FixedInRound(rig, start, result->found, parameters));
    if (parameters == kAllParameters) {
      // What can be told is decided by the information at the present state.
      Eigen::MatrixXd prior;
      Eigen::VectorXd gradient;
      CalibrationPrior(problem, *state, layout, &prior, &gradient);
      CalibrationState probe = *state;
      const Eigen::MatrixXd information = SolveJointProblem(problem, 1, cancellation, &probe).information;
      if (information.size() == 0) break;
      hold(WithFocalLengths(rig, held,
                            HoldUndeterminedIntrinsics(information + prior, *state, layout, held,
                                                       PatternSensitivity(problem.drives, cameras))));
      PlaceHeldTangentialTerms(problem.cameras, state);
    }
    SolveSummary summary = SolveJointProblem(problem, planned ? 4 : 3, cancellation, state);
    if (summary.information.size() == 0 && planned) continue;  // all steps damped: the next round goes on
    if (summary.information.size() == 0) break;
    PlaceLandmarks(std::move(summary.landmarks), &problem);
    // The least sigma of planned rounds is not the tracks' own.
    if (!planned) options.noise = MeasureLandmarkNoise(problem.drives, *state, options);
    result->information = summary.information;
    if (planned) continue;
    if (ChangeInSigmas(before, *state, layout, held, summary.information) < kStandsStill) break;
  }
  result->noise = options.noise;
  result->landmarks.clear();
  for (DriveTerms& drive : problem.drives) result->landmarks.push_back(std::move(drive.landmarks));
}

CameraInitialization InitializeCameras(const Rig& rig, const std::vector<CameraStart>& start,
                                       const std::vector<TrackSet>& tracks, const CalibrationState& given,
                                       const CancellationToken& cancellation) {
  CameraInitialization result;
  const std::size_t cameras = rig.cameras.size();
  result.cameras.resize(cameras);
  result.found.assign(cameras, false);
  std::vector<const SplitSpline*> trajectories;
  for (const DriveState& drive : given.drives) trajectories.push_back(&drive.trajectory);
  for (std::size_t c = 0; c < cameras; ++c) {
    cancellation.ThrowIfCancelled();
    const CameraConfig& config = rig.cameras[c];
    CameraCalibration& camera = result.cameras[c] = CameraAsGiven(config, start[c]);
    CameraAlignment alignment;
    result.found[c] =
        config.fixed || AlignCamera(config, start[c], MatchesOfKeyframes(tracks, static_cast<int>(c)),
                                    trajectories, &camera, &alignment);
    if (!result.found[c]) {
      result.problems.push_back({config.name, AlignmentProblem(config.name)});
    } else if (!config.fixed) {
      result.notes.push_back(AlignmentNote(config.name, camera, alignment.rotation));
    }
  }
  CalibrationState state;
  state.drives = given.drives;
  state.cameras = result.cameras;
  CameraAdjustment adjustment;
  adjustment.problem.fix_trajectory = true;
  AdjustCameras(rig, start, tracks, std::move(adjustment), cancellation, &state, &result);
  result.cameras = state.cameras;
  JudgeCameras(rig, &result);
  return result;
}

void AdjustCamerasFurther(const Rig& rig, const std::vector<CameraStart>& start,
                          const std::vector<TrackSet>& tracks, const CalibrationState& given,
                          const CancellationToken& cancellation, CameraInitialization* cameras) {
  CalibrationState state;
  state.drives = given.drives;
  state.cameras = cameras->cameras;
  CameraAdjustment adjustment;
  adjustment.problem.fix_trajectory = true;
  // The last of the planned rounds lets cameras as they were found agree with other tracks.
  adjustment.rounds.first = static_cast<int>(std::size(kRounds)) - 1;
  AdjustCameras(rig, start, tracks, std::move(adjustment), cancellation, &state, cameras);
  cameras->cameras = state.cameras;
  JudgeCameras(rig, cameras);
}

void JudgeCameras(const Rig& rig, CameraInitialization* judged) {
  CameraInitialization& result = *judged;
  const std::size_t cameras = rig.cameras.size();
  const std::vector<std::size_t> counts = CountObservations(result.landmarks, cameras);
  for (std::size_t c = 0; c < cameras; ++c) {
    if (!result.found[c]) continue;
    char line[240];
    if (counts[c] < kFewestObservations) {
      result.found[c] = false;
      std::snprintf(
          line, sizeof(line),
          "%s: only %zu observations of points agree with the trajectory; record more texture or nearer "
          "structure, or check model and field of view",
          rig.cameras[c].name.c_str(), counts[c]);
      result.problems.push_back({rig.cameras[c].name, line});
      continue;
    }
    if (result.noise[c].spread > kLargestSpread) {
      result.found[c] = false;
      std::snprintf(
          line, sizeof(line),
          "%s: its observations of points scatter by %.1f times the noise of its features, the limit "
          "is %.0f; check model, intrinsics or field of view, and shutter",
          rig.cameras[c].name.c_str(), result.noise[c].spread, kLargestSpread);
      result.problems.push_back({rig.cameras[c].name, line});
      continue;
    }
    const SensorCalibration& sensor = result.cameras[c].sensor;
    std::snprintf(line, sizeof(line), "%s: %zu observations, %.2f of the expected noise, offset %.2f ms",
                  rig.cameras[c].name.c_str(), counts[c], result.noise[c].spread, 1e3 * sensor.time_offset);
    result.notes.push_back(line);
  }
}

}  // namespace mlic
