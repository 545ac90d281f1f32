#include "mlic_core/pipeline/joint_adjustment.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/association/group_errors.h"
#include "mlic_core/association/held_out_matches.h"
#include "mlic_core/association/landmark_noise.h"
#include "mlic_core/association/map_matches.h"
#include "mlic_core/association/plane_association.h"
#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/initialization/guess_check.h"
#include "mlic_core/pipeline/imu_review.h"
#include "mlic_core/pipeline/sensor_review.h"
#include "mlic_core/pipeline/stamp_review.h"
#include "mlic_core/problem/noise_information.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/uncertainty/held_translations.h"
#include "mlic_core/uncertainty/imu_matrices.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"
#include "mlic_core/uncertainty/range_corrections.h"
#include "mlic_core/uncertainty/stamp_doubt.h"

namespace mlic {
namespace {

// Points of each scan once the map has settled. Where few of them lie on planes (streets with trees and
// cars), rounds take more, until so many of a scan do: which points just lie on planes and which just do not
// then weighs less.
constexpr std::size_t kManyPoints = 2000;  // from: measured, kitti_0005 and the car of 4 LiDARs
constexpr std::size_t kMostPoints = 6000;  // from: guard, time
constexpr double kPointsOnPlanes = 500.0;  // from: measured, kitti_0005 and the car of 4 LiDARs
constexpr int kLeastRounds = 5;
constexpr int kMostRounds = 15;  // from: guard, time
// After a move of a sigma, or what a review frees or corrects, so many rounds may follow, in all.
constexpr int kRoundsAfterMove = 5, kMostAfterMoves = 30;  // from: guard, time
constexpr int kMostWhileGrowing = 60;                      // from: guard, time
constexpr double kGrowth = 1.05;  // times the points on planes; from: guard, less is scatter
// Rounds that find landmarks and matches anew, further ones while they move the calibration by its sigma, and
// once the stamps of cameras have moved. Later ones keep them, as which of them just agree and which just do
// not would change for ever. from: measured, paper rig, seeds 1 to 3; what agrees, then its noise
constexpr int kLandmarkRounds = 3;

// Light, shade and the map move all matches of a camera by some 0.2 px together, which their scatter does not
// show: so many of their claimed sigmas they count for at least. With less (paper rig, 60 s) they pull the
// intrinsics of fisheyes 0.3 px off that the tracks have right to 0.1 px. from: measured, paper rig, 60 s
constexpr double kLeastMatchNoise = 4.0;

void BeginRounds(Landmarks landmarks, Adjustment* adjustment) {
  adjustment->rounds.landmarks = landmarks;
  adjustment->rounds.done = 0;
  adjustment->rounds.last_move = 0;
  adjustment->rounds.most_points = 0;
  adjustment->rounds.last_growth = 0;
  adjustment->rounds.landmark_rounds = kLandmarkRounds;
  adjustment->rounds.noise_measured = false;
  adjustment->rounds.clocks_freed = false;
  adjustment->rounds.stamps_settled = false;
  adjustment->rounds.matrices_judged = false;
  adjustment->rounds.biases_judged = false;
  adjustment->rounds.ranges_measured = false;
  adjustment->rounds.walks_dropped = false;
  if (landmarks != Landmarks::kTracksAndMap) return;
  adjustment->map.cameras_before = adjustment->state.cameras;
  adjustment->map.noise.assign(adjustment->state.cameras.size(), {kLeastMatchNoise});
}

void MatchMap(const AdjustmentContext& context, Adjustment* adjustment) {
  const AdjustedCameras& cameras = adjustment->cameras;
  std::vector<DriveTerms>& drives = adjustment->problem.drives;
  MapMatchingOptions options;
  options.noise = adjustment->map.noise;
  options.features = context.features;
  const std::vector<TrackSet> tracks = OnTime(cameras);
  const MatchedCameras matched{tracks, cameras.sigmas, cameras.found, adjustment->rejected_lidars};
  MapMatches matches =
      MatchCamerasToMap(context.dataset, adjustment->state, matched, options, context.monitor);
  for (std::size_t c = 0; c < context.rig.cameras.size(); ++c) {
    if (!cameras.found[c]) continue;
    char text[200];
    std::snprintf(text, sizeof(text), "%s: %zu matches with the map, %.0f %% of all; NID %.4f",
                  context.rig.cameras[c].name.c_str(), matches.counts[c], 100.0 * matches.inlier_share[c],
                  matches.nid[c]);
    context.monitor.line(text);
  }
  adjustment->map.held_out.clear();
  for (std::size_t d = 0; d < drives.size(); ++d) {
    adjustment->map.held_out.push_back(TakeHeldOutMatches(&matches.landmarks[d]));
    WeakenMatches(adjustment->map.noise, adjustment->state, d, &matches.landmarks[d]);
    Append(matches.landmarks[d], &drives[d].landmarks);
  }
}

void AssociateWithLandmarks(const AdjustmentContext& context, Adjustment* adjustment) {
  const AdjustedCameras& cameras = adjustment->cameras;
  const std::vector<TrackSet> tracks = OnTime(cameras);
  for (std::size_t d = 0; d < tracks.size(); ++d) {
    adjustment->problem.drives[d].landmarks =
        TriangulateLandmarks(tracks[d], adjustment->state, d, cameras.landmark_options);
  }
  if (adjustment->rounds.landmarks == Landmarks::kTracksAndMap) MatchMap(context, adjustment);
}

void MeasureLandmarks(Adjustment* adjustment) {
  const std::vector<DriveTerms>& drives = adjustment->problem.drives;
  LandmarkOptions& options = adjustment->cameras.landmark_options;
  options.noise = MeasureLandmarkNoise(drives, adjustment->state, options);
  if (adjustment->rounds.landmarks != Landmarks::kTracksAndMap) return;
  adjustment->map.noise = MeasureMatchNoise(drives, adjustment->state, adjustment->map.noise);
  for (MatchNoise& noise : adjustment->map.noise) noise.scale = std::max(kLeastMatchNoise, noise.scale);
}

// For the next round: intrinsics that the present solve shows well enough move in it.
void FixUnobservableIntrinsics(const Dataset& dataset, Adjustment* adjustment) {
  JointProblem& problem = adjustment->problem;
  const CalibrationState& state = adjustment->state;
  const Layout layout(state, problem.estimate_imu_matrices);
  if (adjustment->last_solve.information.rows() != layout.calibration) return;
  for (CameraTerms& camera : problem.cameras) {  // decided anew
    camera.fixed.square_pixels = camera.fixed.usual_centre = false;
  }
  Eigen::MatrixXd prior;
  Eigen::VectorXd gradient;
  CalibrationPrior(problem, state, layout, &prior, &gradient);
  const std::vector<FixedCameraParameters> held = HoldUndeterminedIntrinsics(
      ScaledInformation(*adjustment, dataset) + prior, state, layout, adjustment->cameras.always_fixed,
      PatternSensitivity(problem.drives, state.cameras.size()));
  for (std::size_t c = 0; c < held.size(); ++c) problem.cameras[c].fixed = held[c];
  PlaceHeldTangentialTerms(problem.cameras, &adjustment->state);
}

void DropContradictedGuesses(Adjustment* adjustment) {
  JointProblem& problem = adjustment->problem;
  const SensorOrder order = adjustment->state.Sensors();
  for (std::size_t s = 0; s < order.size(); ++s) {
    if (!adjustment->contradicted_guesses[s]) continue;
    const SensorId id = order.At(s);
    (id.IsLidar() ? problem.lidars[id.index].guess : problem.cameras[id.index].guess).reset();
  }
}

// Guesses that the calibration contradicts count no more, once it hardly moves in terms of their sigmas (a
// wrong one can keep it moving by many of its own). True if there is a new one. before: the round.
bool FindContradictedGuesses(const AdjustmentContext& context, const CalibrationState& before,
                             Adjustment* adjustment) {
  const SensorOrder order = adjustment->state.Sensors();
  bool found = false;
  for (std::size_t s = 0; s < order.size(); ++s) {
    const SensorId id = order.At(s);
    const bool takes_part =
        id.IsLidar() ? !adjustment->rejected_lidars[id.index] : adjustment->cameras.found[id.index];
    const std::optional<ExtrinsicGuess>& guess = GuessOf(id, adjustment->problem);
    if (!takes_part || !guess) continue;
    const RigidTransform& now = adjustment->state.Sensor(id).T_imu_sensor;
    ExtrinsicGuess last = *guess;
    last.T_imu_sensor = before.Sensor(id).T_imu_sensor;
    if (SigmasFromGuess(last, now) > 1.0 || !ContradictsGuess(*guess, now)) continue;
    found = adjustment->contradicted_guesses[s] = true;
    context.monitor.line(NameOf(id, context.rig) +
                         ": the given T_imu_sensor contradicts the data and counts no more");
  }
  if (found) DropContradictedGuesses(adjustment);
  return found;
}

// Once in the rounds, when the trajectory has settled, and once at their end.
void MeasureNoise(const AdjustmentContext& context, const LinearizedProblem& linearized,
                  Adjustment* adjustment) {
  adjustment->noise_information = NoiseInformation(linearized, context.monitor.cancellation);
  adjustment->rounds.noise_measured = true;
}

void MeasureNoiseAndScale(const AdjustmentContext& context, Adjustment* adjustment) {
  const LinearizedProblem linearized(adjustment->problem, adjustment->state);
  MeasureNoise(context, linearized, adjustment);
  MeasureScale(linearized, *adjustment, &adjustment->scale);
}

// Remembers rounds whose map ties clearly more points to planes than any of theirs before.
void NoteGrowth(Adjustment* adjustment) {
  std::size_t points = 0;
  for (const DriveTerms& drive : adjustment->problem.drives) points += drive.planes.observations.size();
  JointRounds& rounds = adjustment->rounds;
  if (static_cast<double>(points) <= kGrowth * static_cast<double>(rounds.most_points)) return;
  rounds.most_points = points;
  rounds.last_growth = rounds.done + 1;
}

// True if the next round takes more points of each scan.
bool TakeMorePoints(const Dataset& dataset, Adjustment* adjustment) {
  std::size_t& points_per_scan = adjustment->rounds.points_per_scan;
  double scans = 0.0;
  for (const Drive& drive : dataset.drives) {
    for (const LidarRecording& lidar : drive.lidars) scans += static_cast<double>(lidar.scans.size());
  }
  const double share =
      static_cast<double>(adjustment->last_solve.observations) / (kPointsOnPlanes * std::max(1.0, scans));
  if (share > 0.9 || points_per_scan >= kMostPoints) return false;
  points_per_scan = std::min(
      kMostPoints, static_cast<std::size_t>(static_cast<double>(points_per_scan) / std::max(0.5, share)));
  return true;
}

// Association, solve, and the noise that its residuals show.
void AssociateAndSolve(const AdjustmentContext& context, bool many, bool probe_matrices,
                       Adjustment* adjustment) {
  const int round = adjustment->rounds.done;
  JointProblem& problem = adjustment->problem;
  problem.estimate_imu_matrices |=
      context.rig.imu.intrinsics == ImuIntrinsicsModel::kScaleMisalignment && (round >= 2 || many);
  std::vector<bool> taking_part = adjustment->rejected_lidars;
  taking_part.flip();
  AssociateWithPlanes(context, taking_part, adjustment->rounds.points_per_scan, many, adjustment);
  // Landmarks that are kept were made with an earlier noise.
  const bool landmarks =
      adjustment->rounds.landmarks != Landmarks::kNone && round < adjustment->rounds.landmark_rounds;
  if (landmarks) AssociateWithLandmarks(context, adjustment);
  adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment, probe_matrices);
  adjustment->plane_noise = MeasurePlaneNoise(problem.drives, adjustment->state, adjustment->plane_noise);
  if (many) MeasureSharedErrors(problem.drives, adjustment->state, &adjustment->plane_noise);
  if (landmarks) MeasureLandmarks(adjustment);
  MeasureImuSigmas(context.dataset, adjustment);
}

std::string DescribeRound(const Adjustment& adjustment, double change) {
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "round %d: %zu planes, %zu points, %zu observations of landmarks, cost %.0f, calibration moved by "
      "%.2f of its sigma",
      adjustment.rounds.done + 1, adjustment.problem.drives[0].planes.planes.size(),
      adjustment.last_solve.observations, adjustment.last_solve.landmark_observations,
      adjustment.last_solve.last_cost, change);
  return text;
}

// Solves once more with what the data do not show of translations at the guesses. True if there is any.
bool HoldUnobservableTranslations(const AdjustmentContext& context, Adjustment* adjustment) {
  JointProblem& problem = adjustment->problem;
  const ObservabilityAnalysis analysis = Analyze(*adjustment, context.dataset);
  problem.held_translations = UnobservableTranslations(problem, adjustment->state.Sensors(), analysis);
  if (problem.held_translations.empty()) return false;
  adjustment->shown_before_hold = analysis.sensors;
  adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment, true);
  context.monitor.line(std::to_string(problem.held_translations.size()) +
                       " directions of translation that the motion does not show stand at the guesses");
  return true;
}

}  // namespace

const char* NameOf(Landmarks landmarks) {
  switch (landmarks) {
    case Landmarks::kNone:
      return "joint adjustment";
    case Landmarks::kTracks:
      return "joint adjustment with cameras";
    case Landmarks::kTracksAndMap:
      return "joint calibration on the map";
  }
  return "";
}

int MostRounds(const JointRounds& rounds) {
  const int after_moves =
      std::max(kMostAfterMoves, std::min(rounds.last_growth + kRoundsAfterMove, kMostWhileGrowing));
  return std::clamp(rounds.last_move + kRoundsAfterMove, kMostRounds, after_moves);
}

Adjustment AdjustJointly(Adjustment adjustment, const AdjustmentContext& context,
                         const JointOptions& options) {
  const bool cameras = options.landmarks != Landmarks::kNone;
  const int least_rounds = cameras ? kLandmarkRounds : kLeastRounds;
  JointRounds& rounds = adjustment.rounds;
  if (rounds.landmarks != options.landmarks) BeginRounds(options.landmarks, &adjustment);
  DropContradictedGuesses(&adjustment);
  rounds.unsettled = 0.0;
  while (rounds.done < MostRounds(rounds)) {
    const int round = rounds.done;
    const bool many = rounds.points_per_scan > kFewPoints;
    const CalibrationState before = adjustment.state;
    const std::ptrdiff_t corrections = CountCorrections(before);
    const bool probe_matrices = options.find_sensor_errors && options.find_imu_axes && many;
    AssociateAndSolve(context, many, probe_matrices, &adjustment);
    const double change = ChangeInSigmas(adjustment, context.dataset, before);
    rounds.last_change = change;
    NoteGrowth(&adjustment);
    rounds.history.push_back({NameOf(options.landmarks), change});
    if (many && !rounds.noise_measured) {
      MeasureNoise(context, {adjustment.problem, adjustment.state}, &adjustment);
    }
    if (round + 1 == rounds.landmark_rounds && change >= 1.0) ++rounds.landmark_rounds;
    // Not before: extrinsics on their way look like clocks that drift, and like rings and ranges that err.
    const bool settled = options.find_sensor_errors && many && change < 1.0;
    const SensorError found =
        settled ? FindSensorError(context, probe_matrices, &adjustment) : SensorError::kNone;
    if (!adjustment.state.lidars.empty()) {
      adjustment.cameras.sigmas =
          SigmasAgainstLidar(Analyze(adjustment, context.dataset), adjustment.state, adjustment.base_lidar);
    }
    const bool axes_moved = options.find_imu_axes && ReviewAxes(context, &adjustment);
    context.monitor.line(DescribeRound(adjustment, change));
    ShowAdjustment(context, NameOf(options.landmarks), round, adjustment, change);
    context.monitor.progress(std::min(0.95, (round + 1.0) / (least_rounds + 2)));
    // Corrections that are there already go on moving by less than the calibration's sigmas.
    const bool corrected = CountCorrections(adjustment.state) != corrections;
    const bool freed = (found != SensorError::kNone && found != SensorError::kRanges) || axes_moved;
    if (freed || corrected || change >= 1.0) rounds.last_move = round + 1;
    const bool more = many && TakeMorePoints(context.dataset, &adjustment);
    const bool guess_dropped =
        round + 1 < MostRounds(rounds) && FindContradictedGuesses(context, before, &adjustment);
    if (many && !more && !freed && found == SensorError::kNone && !guess_dropped && change < options.until &&
        round + 1 >= least_rounds) {
      break;
    }
    // The map has settled once the noise has: then all points take part.
    if (!many && (change < 1.0 || round + 1 >= least_rounds - 1)) rounds.points_per_scan = kManyPoints;
    ++rounds.done;
    if (rounds.done == MostRounds(rounds)) {
      // What is held stays as the last solve had it, or a parameter that never moved would pass for
      // estimated.
      rounds.unsettled = change;
      break;
    }
    if (cameras) FixUnobservableIntrinsics(context.dataset, &adjustment);
    options.after_round(adjustment);
  }
  return adjustment;
}

void MeasureUncertainty(const AdjustmentContext& context, Adjustment* adjustment) {
  adjustment->scale = {};
  WeakenImuBySlowErrors(context, adjustment);
  MeasureNoiseAndScale(context, adjustment);
  if (HoldUnobservableTranslations(context, adjustment)) {
    MeasureScale({adjustment->problem, adjustment->state}, *adjustment, &adjustment->scale);
  }
  adjustment->scale.inflation.points +=
      ScatterOfMatrices(adjustment->problem, adjustment->state, adjustment->last_solve.imu_matrices,
                        VarianceScale(*adjustment, context.dataset));
  const CalibrationState& state = adjustment->state;
  DoubtConstantBiases(context, adjustment);
  const auto& line = context.monitor.line;
  if (adjustment->rounds.landmarks == Landmarks::kTracksAndMap) {
    MapMatching& map = adjustment->map;
    map.held_out_errors = EvaluateHeldOutMatches(map.held_out, state);
    for (std::size_t c = 0; c < map.held_out_errors.size(); ++c) {
      if (map.held_out_errors[c].count == 0) continue;
      const std::string& name = context.rig.cameras[c].name;
      line(name + DescribeMatchNoise(map.noise[c]));
      line(name + DescribeHeldOut(map.held_out_errors[c]));
    }
  }
  const CovarianceScale& scale = adjustment->scale;
  char text[200];
  std::snprintf(text, sizeof(text), "points share errors: sigmas grow by a factor of %.2f",
                std::sqrt(scale.correlation));
  line(text);
  for (std::size_t l = 0; l < state.rings.size(); ++l) {
    const std::string found = DescribeCorrections(state, l);
    if (!found.empty()) line(context.rig.lidars[l].name + found);
  }
  for (const std::string& text : DescribeInflation(scale.inflation.cameras, context.rig, state)) line(text);
}

}  // namespace mlic
