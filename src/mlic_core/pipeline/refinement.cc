#include "mlic_core/pipeline/refinement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/association/held_out_matches.h"
#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/guess_check.h"
#include "mlic_core/summary/result_assembly.h"
#include "mlic_core/summary/snapshot.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"

namespace mlic {
namespace {

// Of each scan. The first rounds find the map with few points; the last ones measure with many. Where few of
// them lie on planes (streets with trees and cars), they take more, until so many of a scan do: which points
// just lie on planes and which just do not then weighs less.
constexpr std::size_t kFewPoints = 800;
constexpr std::size_t kManyPoints = 2000;
constexpr std::size_t kMostPoints = 6000;
constexpr double kPointsOnPlanes = 500.0;
constexpr double kMostUnsettled = 10.0;  // sigmas
constexpr int kLeastRounds = 5;
constexpr int kMostRounds = 15;
// Of Gauss-Newton in each round: a stretch of trajectory that starts beside the map comes back in several.
constexpr int kMostIterations = 6;
constexpr int kLeastRoundsWithCameras = 3;
// Rounds that find landmarks and matches anew; later ones keep them, as which of them just agree and which
// just do not would change for ever.
constexpr int kLandmarkRounds = 3;
// Of a observation of a landmark whose noise is its own, in its sigmas. That noise already makes wrong
// observations count for little. Judged more strictly, observations that agree with the calibration as it
// stands win over those that do not, and its errors grow from round to round.
constexpr double kLargestOwnError = 8.0;

// Light, shade and the map move all matches of a camera by some 0.2 px together, which their scatter does not
// show: so many of their claimed sigmas they count for at least. With less (paper rig, 60 s) they pull the
// intrinsics of fisheyes 0.3 px off that the tracks have right to 0.1 px.
constexpr double kLeastMatchNoise = 4.0;

}  // namespace

Refinement::Refinement(const Rig& rig, const Dataset& dataset, Initialization start,
                       const CancellationToken& cancellation, CalibrationObserver& observer)
    : rig_(rig),
      dataset_(dataset),
      cancellation_(cancellation),
      observer_(observer),
      base_lidar_(start.base_lidar),
      unaligned_lidars_(start.unaligned),
      rejected_lidars_(rig.lidars.size(), false),
      state_(std::move(start.state)),
      given_imu_sigma_(start.imu_sigma),
      noise_(rig.lidars.size()),
      points_per_scan_(kFewPoints) {
  initial_.lidars = state_.lidars;
  problem_.dataset = &dataset;
  problem_.imu_sigma = start.imu_sigma;
  for (const LidarConfig& lidar : rig.lidars) {
    problem_.guesses.push_back(lidar.fixed ? std::nullopt : lidar.guess);
    problem_.lidar_fixed.push_back(lidar.fixed);
  }
}

void Refinement::Associate(const std::vector<bool>& lidars, std::size_t points_per_scan) {
  AssociationOptions options;
  options.root_voxel = RootVoxelSize(dataset_.drives[0]);
  options.points_per_scan = points_per_scan;
  options.lidars = lidars;
  problem_.planes.clear();
  for (std::size_t d = 0; d < dataset_.drives.size(); ++d) {
    cancellation_.ThrowIfCancelled();
    problem_.planes.push_back(AssociatePlanes(dataset_.drives[d], state_, d, noise_, options));
  }
}

SolveSummary Refinement::Solve(int iterations) {
  SolveSummary summary = SolveJointProblem(problem_, iterations, cancellation_, &state_);
  // Residuals to planes where the solve did not leave them would look like noise.
  for (std::size_t d = 0; d < problem_.planes.size(); ++d) {
    problem_.planes[d].planes = std::move(summary.planes[d]);
  }
  for (std::size_t d = 0; d < problem_.landmarks.size(); ++d) {
    problem_.landmarks[d].points = std::move(summary.points[d]);
  }
  summary.planes.clear();
  summary.points.clear();
  return summary;
}

void Refinement::MatchMap() {
  match_map_ = true;
  cameras_before_map_ = state_.cameras;
  match_noise_.assign(rig_.cameras.size(), kLeastMatchNoise);
  rounds_ = 0;
}

void Refinement::AssociateLandmarks(const Progress& progress, const Line& line) {
  problem_.landmarks = TriangulateLandmarks(tracks_, state_, landmark_options_);
  if (!match_map_) return;
  MapMatchingOptions options;
  options.noise_scale = match_noise_;
  MapMatches matches =
      MatchCamerasToMap(dataset_, tracks_, state_, sigmas_, cameras_found_, options, progress, cancellation_);
  for (std::size_t c = 0; c < rig_.cameras.size(); ++c) {
    if (!cameras_found_[c]) continue;
    char text[200];
    std::snprintf(text, sizeof(text), "%s: %zu matches with the map, %.0f %% of all; NID %.4f",
                  rig_.cameras[c].name.c_str(), matches.counts[c], 100.0 * matches.inlier_share[c],
                  matches.nid[c]);
    line(text);
  }
  held_out_.clear();
  for (std::size_t d = 0; d < problem_.landmarks.size(); ++d) {
    held_out_.push_back(TakeHeldOutMatches(&matches.landmarks[d]));
    Append(matches.landmarks[d], &problem_.landmarks[d]);
  }
}

// For the next round: intrinsics that the present solve shows well enough move in it.
void Refinement::FixUnobservable() {
  const Layout layout(state_, problem_.estimate_imu_matrices);
  if (last_solve_.information.rows() != layout.calibration) return;
  for (FixedCameraParameters& held : problem_.camera_fixed) held.square_pixels = false;  // decided anew
  Eigen::MatrixXd prior;
  Eigen::VectorXd gradient;
  CalibrationPrior(problem_, state_, layout, &prior, &gradient);
  problem_.camera_fixed =
      HoldUndeterminedIntrinsics(ScaledInformation() + prior, state_, layout, always_fixed_,
                                 PatternSensitivity(problem_.landmarks, state_.cameras.size()));
}

void Refinement::AddCameras(const CameraInitialization& cameras, const std::vector<TrackSet>& tracks) {
  state_.cameras = initial_.cameras = cameras.cameras;
  cameras_found_ = cameras.found;
  tracks_ = WithoutLostCameras(tracks, cameras.found);
  // The cameras are not yet as right as single observations are sharp: the first round judges less strictly.
  for (const LandmarkNoise& noise : cameras.noise) {
    landmark_options_.noise.push_back({noise.spread * noise.dependence, 1.0});
  }
  landmark_options_.noise_of_each = true;
  landmark_options_.largest_error = kLargestOwnError;
  problem_.camera_fixed = cameras.held;
  for (std::size_t c = 0; c < rig_.cameras.size(); ++c) {
    const CameraConfig& config = rig_.cameras[c];
    const bool still = config.fixed || !cameras.found[c];
    problem_.camera_guesses.push_back(config.fixed ? std::nullopt : config.guess);
    always_fixed_.push_back({still, still, still, !cameras.found[c], {}});
    always_fixed_.back().intrinsics.assign(state_.cameras[c].intrinsics.parameters.size(), !cameras.found[c]);
  }
  rounds_ = 0;
}

void Refinement::MeasureImuSigma() {
  constexpr std::size_t kFewest = 35;  // samples
  // Vibration above what the spline can carry, and errors that the data sheet leaves out, add to the noise.
  for (std::size_t d = 0; d < dataset_.drives.size(); ++d) {
    const ImuResiduals residuals = EvaluateImuResiduals(dataset_, state_, d);
    if (residuals.values.size() < kFewest) continue;
    const auto measured = [&](int component) {
      std::vector<double> sizes;
      for (const auto& value : residuals.values) sizes.push_back(std::abs(value[component]));
      return 1.4826 * Median(std::move(sizes));
    };
    for (int a = 0; a < 3; ++a) {
      problem_.imu_sigma[d].gyroscope[a] = std::max(given_imu_sigma_[d].gyroscope[a], measured(a));
      problem_.imu_sigma[d].accelerometer[a] =
          std::max(given_imu_sigma_[d].accelerometer[a], measured(3 + a));
    }
  }
}

void Refinement::AdjustEachLidar(const Progress& progress, const Line& line) {
  constexpr int kRounds = 3;
  const std::size_t lidars = rig_.lidars.size();
  std::vector<std::size_t> order{base_lidar_};
  for (std::size_t l = 0; l < lidars; ++l) {
    if (l != base_lidar_) order.push_back(l);
  }
  const std::vector<bool> held = problem_.lidar_fixed;
  for (std::size_t k = 0; k < lidars; ++k) {
    const std::size_t lidar = order[k];
    std::vector<bool> only(lidars, false);
    only[lidar] = true;
    for (std::size_t l = 0; l < lidars; ++l) problem_.lidar_fixed[l] = held[l] || l != lidar;
    problem_.fix_trajectory = lidar != base_lidar_;
    for (int round = 0; round < kRounds; ++round) {
      Associate(only, kFewPoints);
      Solve(kMostIterations);
      noise_ = MeasurePlaneNoise(problem_.planes, state_, noise_);
      progress((static_cast<double>(k) + (round + 1.0) / kRounds) / static_cast<double>(lidars));
    }
    char text[160];
    std::snprintf(text, sizeof(text), "%s: %zu planes, points off them by %.1f mm",
                  rig_.lidars[lidar].name.c_str(), problem_.planes[0].planes.size(),
                  1e3 * noise_[lidar].Sigma(1.0));
    line(text);
    Show("plane adjustment of each LiDAR", static_cast<int>(k));
  }
  problem_.lidar_fixed = held;
  problem_.fix_trajectory = false;
  // LiDARs still disagree by what their own adjustments could not see; the common map must bridge that.
  for (PlaneNoise& noise : noise_) noise.floor = std::max(noise.floor, 0.05);
}

void Refinement::RejectLostLidars(const Line& line) {
  for (std::size_t l = 0; l < unaligned_lidars_.size(); ++l) {
    const LidarConfig& config = rig_.lidars[l];
    if (!unaligned_lidars_[l] || config.fixed || !IsLostFromGuess(config, state_.lidars[l].T_imu_sensor))
      continue;
    rejected_lidars_[l] = problem_.lidar_fixed[l] = true;
    line(config.name + ": left out, its planes lead far from where it started");
  }
}

void Refinement::AdjustJointly(double until, const Progress& progress, const Line& line,
                               const std::function<void()>& after_round) {
  const std::string stage = tracks_.empty() ? "joint adjustment"
                            : match_map_    ? "joint calibration on the map"
                                            : "joint adjustment with cameras";
  const int least_rounds = tracks_.empty() ? kLeastRounds : kLeastRoundsWithCameras;
  unsettled_ = 0.0;
  while (rounds_ < kMostRounds) {
    const int round = rounds_;
    const bool many = points_per_scan_ > kFewPoints;
    const CalibrationState before = state_;
    problem_.estimate_imu_matrices =
        rig_.imu.intrinsics == ImuIntrinsicsModel::kScaleMisalignment && (round >= 2 || many);
    std::vector<bool> taking_part = rejected_lidars_;
    taking_part.flip();
    Associate(taking_part, points_per_scan_);
    if (!tracks_.empty() && round < kLandmarkRounds) AssociateLandmarks(progress, line);
    last_solve_ = Solve(kMostIterations);
    noise_ = MeasurePlaneNoise(problem_.planes, state_, noise_);
    // Landmarks that are kept were made with an earlier noise.
    if (!tracks_.empty() && round < kLandmarkRounds) {
      landmark_options_.noise = MeasureLandmarkNoise(problem_.landmarks, state_, landmark_options_);
      if (match_map_) {
        const std::vector<double> noise = MeasureMatchNoise(problem_.landmarks, state_);
        for (std::size_t c = 0; c < noise.size(); ++c)
          match_noise_[c] = std::max(kLeastMatchNoise, match_noise_[c] * noise[c]);
      }
    }
    MeasureImuSigma();
    const double change = ChangeInSigmas(before);
    // Not before: extrinsics on their way look like rings that err.
    const bool rings_moved = many && change < 1.0 && CorrectRings(problem_.planes, &state_);
    if (!state_.lidars.empty()) sigmas_ = SigmasAgainstLidar(Analyze(), state_, base_lidar_);
    char text[200];
    std::snprintf(
        text, sizeof(text),
        "round %d: %zu planes, %zu points, %zu observations of landmarks, cost %.0f, calibration moved by "
        "%.2f of its sigma",
        round + 1, problem_.planes[0].planes.size(), last_solve_.observations,
        last_solve_.landmark_observations, last_solve_.last_cost, change);
    line(text);
    Show(stage, round);
    progress(std::min(0.95, (round + 1.0) / (least_rounds + 2)));
    const bool more = many && TakeMorePoints();
    if (many && !more && !rings_moved && change < until && round + 1 >= least_rounds) break;
    // The map has settled once the noise has: then all points take part.
    if (!many && (change < 1.0 || round + 1 >= least_rounds - 1)) points_per_scan_ = kManyPoints;
    if (!tracks_.empty()) FixUnobservable();
    ++rounds_;
    if (rounds_ < kMostRounds) {
      after_round();
    } else {
      unsettled_ = std::min(change, kMostUnsettled);
    }
  }
}

bool Refinement::TakeMorePoints() {
  double scans = 0.0;
  for (const Drive& drive : dataset_.drives) {
    for (const LidarRecording& lidar : drive.lidars) scans += static_cast<double>(lidar.scans.size());
  }
  const double share =
      static_cast<double>(last_solve_.observations) / (kPointsOnPlanes * std::max(1.0, scans));
  if (share > 0.9 || points_per_scan_ >= kMostPoints) return false;
  points_per_scan_ = std::min(
      kMostPoints, static_cast<std::size_t>(static_cast<double>(points_per_scan_) / std::max(0.5, share)));
  return true;
}

RefinementProgress Refinement::Checkpoint() const {
  return {state_,
          problem_.imu_sigma,
          noise_,
          landmark_options_.noise,
          problem_.camera_fixed,
          sigmas_,
          match_noise_,
          problem_.landmarks,
          rounds_,
          points_per_scan_,
          {},
          held_out_};
}

void Refinement::Restore(const RefinementProgress& progress) {
  state_ = progress.state;
  problem_.imu_sigma = progress.imu_sigma;
  noise_ = progress.noise;
  landmark_options_.noise = progress.landmark_noise;
  problem_.camera_fixed = progress.camera_fixed;
  sigmas_ = progress.sigmas;
  match_noise_ = progress.match_noise;
  problem_.landmarks = progress.landmarks;
  rounds_ = progress.rounds;
  points_per_scan_ = progress.points_per_scan;
  held_out_ = progress.held_out;
}

void Refinement::MeasureHeldOut(const Line& line) {
  held_out_errors_ = EvaluateHeldOutMatches(held_out_, state_);
  for (std::size_t c = 0; c < held_out_errors_.size(); ++c) {
    const HeldOutMatches& error = held_out_errors_[c];
    if (error.count == 0) continue;
    line(rig_.cameras[c].name + DescribeHeldOut(error));
  }
}

void Refinement::MeasureCorrelation(const Line& line) {
  correlation_ = CorrelationFactor(problem_.planes, state_);
  stamp_errors_ = MeasureStampErrors(problem_, state_);
  for (std::size_t l = 0; l < state_.lidars.size(); ++l) {
    correlation_ = std::max(correlation_, stamp_errors_[l].excess);
  }
  char text[200];
  std::snprintf(text, sizeof(text), "points share errors: sigmas grow by a factor of %.2f",
                std::sqrt(correlation_));
  line(text);
  for (std::size_t l = 0; l < state_.rings.size(); ++l) {
    const std::string found = DescribeCorrections(state_.rings[l]);
    if (!found.empty()) line(rig_.lidars[l].name + found);
  }
  if (tracks_.empty()) return;
  camera_doubt_ =
      MeasureCameraDoubt(problem_, state_, landmark_options_,
                         AnalyzeCalibration(problem_, state_, last_solve_.information).solved_covariance);
  for (const std::string& text : DescribeDoubt(camera_doubt_, rig_, state_)) line(text);
}

double Refinement::ChangeInSigmas(const CalibrationState& before) const {
  if (last_solve_.information.size() == 0) return 1e9;
  const ObservabilityAnalysis analysis = Analyze();
  double largest = 0.0;
  const auto compare = [&](const SensorCalibration& a, const SensorCalibration& b, const PoseSigma& sigma) {
    const Eigen::Vector3d rotation = Log(b.T_imu_sensor.rotation * a.T_imu_sensor.rotation.conjugate());
    const Eigen::Vector3d translation = b.T_imu_sensor.translation - a.T_imu_sensor.translation;
    largest = std::max(largest, rotation.cwiseQuotient(sigma.rotation).cwiseAbs().maxCoeff());
    largest = std::max(largest, translation.cwiseQuotient(sigma.translation).cwiseAbs().maxCoeff());
    largest = std::max(largest, std::abs(b.time_offset - a.time_offset) / sigma.time_offset);
  };
  const std::size_t lidars = state_.lidars.size();
  for (std::size_t l = 0; l < lidars; ++l) compare(before.lidars[l], state_.lidars[l], analysis.sigmas[l]);
  for (std::size_t c = 0; c < state_.cameras.size(); ++c) {
    compare(before.cameras[c].sensor, state_.cameras[c].sensor, analysis.sigmas[lidars + c]);
  }
  return largest;
}

double Refinement::VarianceScale() const {
  const double residuals = static_cast<double>(
      std::max<std::size_t>(1, last_solve_.observations + 2 * last_solve_.landmark_observations));
  const double scatter = std::max(1.0, last_solve_.last_cost / (residuals + 6.0 * ImuSampleCount(dataset_)));
  return scatter * correlation_ * (1.0 + unsettled_ * unsettled_);
}

Eigen::MatrixXd Refinement::ScaledInformation() const { return last_solve_.information / VarianceScale(); }

ObservabilityAnalysis Refinement::Analyze() const {
  return AnalyzeCalibration(problem_, state_, ScaledInformation(), camera_doubt_, VarianceScale());
}

void Refinement::Show(const std::string& stage, int iteration) {
  const ObservabilityAnalysis analysis =
      last_solve_.information.size() > 0 ? Analyze() : ObservabilityAnalysis();
  observer_.OnSnapshot(MakeSnapshot(stage, iteration, rig_, dataset_, state_, problem_.planes[0],
                                    analysis.sigmas, last_solve_.last_cost,
                                    problem_.landmarks.empty() ? LandmarkSet() : problem_.landmarks[0]));
}

}  // namespace mlic
