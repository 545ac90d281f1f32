#include "mlic_core/calibration/refinement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/calibration/result_assembly.h"
#include "mlic_core/calibration/snapshot.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

// The first rounds find the map with few points; the last ones measure with many.
constexpr std::size_t kFewPoints = 800;
constexpr std::size_t kManyPoints = 2000;
constexpr int kLeastRounds = 5;
constexpr int kMostRounds = 10;
constexpr double kStandsStill = 0.1;  // of a sigma

}  // namespace

Refinement::Refinement(const Rig& rig, const Dataset& dataset, Initialization start,
                       const CancellationToken& cancellation, CalibrationObserver& observer)
    : rig_(rig),
      dataset_(dataset),
      cancellation_(cancellation),
      observer_(observer),
      base_lidar_(start.base_lidar),
      state_(std::move(start.state)),
      given_imu_sigma_(start.imu_sigma),
      noise_(rig.lidars.size()) {
  problem_.dataset = &dataset;
  problem_.imu_sigma = start.imu_sigma;
  for (const LidarConfig& lidar : rig.lidars) {
    problem_.guesses.push_back(lidar.fixed ? std::nullopt : lidar.guess);
    problem_.lidar_held.push_back(lidar.fixed);
  }
}

double Refinement::RootVoxel() const {
  // A hundredth of what the LiDARs see far, between one and two metres: halls have shelves, yards have
  // facades.
  std::vector<float> ranges;
  for (const LidarRecording& lidar : dataset_.drives[0].lidars) {
    const LidarScan& scan = lidar.scans[lidar.scans.size() / 2];
    for (std::size_t i = 0; i < scan.points.size(); i += 7) ranges.push_back(scan.points[i].position.norm());
  }
  if (ranges.empty()) return 2.0;
  const auto far = ranges.begin() + ranges.size() * 9 / 10;
  std::nth_element(ranges.begin(), far, ranges.end());
  return std::clamp(0.1 * *far, 1.0, 2.0);
}

void Refinement::Associate(const std::vector<bool>& lidars, std::size_t points_per_scan) {
  AssociationOptions options;
  options.root_voxel = RootVoxel();
  options.points_per_scan = points_per_scan;
  options.lidars = lidars;
  problem_.planes.clear();
  for (std::size_t d = 0; d < dataset_.drives.size(); ++d) {
    cancellation_.ThrowIfCancelled();
    problem_.planes.push_back(AssociatePlanes(dataset_.drives[d], state_, d, noise_, options));
  }
}

void Refinement::MeasureImuSigma() {
  // Vibration above what the spline can carry, and errors that the data sheet leaves out, add to the noise.
  for (std::size_t d = 0; d < dataset_.drives.size(); ++d) {
    const ImuResiduals residuals = EvaluateImuResiduals(dataset_, state_, d);
    std::vector<double> gyroscope, accelerometer;
    for (const auto& value : residuals.values) {
      for (int a = 0; a < 3; ++a) {
        gyroscope.push_back(std::abs(value[a]));
        accelerometer.push_back(std::abs(value[3 + a]));
      }
    }
    if (gyroscope.size() < 100) continue;
    const auto sigma = [](std::vector<double>* sizes) {
      const auto middle = sizes->begin() + sizes->size() / 2;
      std::nth_element(sizes->begin(), middle, sizes->end());
      return 1.4826 * *middle;
    };
    problem_.imu_sigma[d].gyroscope = std::max(given_imu_sigma_[d].gyroscope, sigma(&gyroscope));
    problem_.imu_sigma[d].accelerometer = std::max(given_imu_sigma_[d].accelerometer, sigma(&accelerometer));
  }
}

void Refinement::AdjustEachLidar(const Progress& progress, const Line& line) {
  constexpr int kRounds = 3;
  const std::size_t lidars = rig_.lidars.size();
  std::vector<std::size_t> order{base_lidar_};
  for (std::size_t l = 0; l < lidars; ++l) {
    if (l != base_lidar_) order.push_back(l);
  }
  const std::vector<bool> held = problem_.lidar_held;
  for (std::size_t k = 0; k < lidars; ++k) {
    const std::size_t lidar = order[k];
    std::vector<bool> only(lidars, false);
    only[lidar] = true;
    for (std::size_t l = 0; l < lidars; ++l) problem_.lidar_held[l] = held[l] || l != lidar;
    problem_.hold_trajectory = lidar != base_lidar_;
    for (int round = 0; round < kRounds; ++round) {
      Associate(only, kFewPoints);
      SolveJointProblem(problem_, 2, cancellation_, &state_);
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
  problem_.lidar_held = held;
  problem_.hold_trajectory = false;
  // LiDARs still disagree by what their own adjustments could not see; the common map must bridge that.
  for (PlaneNoise& noise : noise_) noise.floor = std::max(noise.floor, 0.05);
}

void Refinement::AdjustJointly(const Progress& progress, const Line& line,
                               const std::function<void()>& after_round) {
  while (rounds_ < kMostRounds) {
    const int round = rounds_;
    const bool many = many_points_;
    const CalibrationState before = state_;
    problem_.estimate_imu_matrices =
        rig_.imu.intrinsics == ImuIntrinsicsModel::kScaleMisalignment && round >= 2;
    Associate({}, many ? kManyPoints : kFewPoints);
    // One step is enough while the association still changes.
    last_solve_ = SolveJointProblem(problem_, round == 0 || many ? 2 : 1, cancellation_, &state_);
    noise_ = MeasurePlaneNoise(problem_.planes, state_, noise_);
    MeasureImuSigma();
    const double change = ChangeInSigmas(before);
    char text[200];
    std::snprintf(text, sizeof(text),
                  "round %d: %zu planes, %zu points, cost %.0f, calibration moved by %.2f of its sigma",
                  round + 1, problem_.planes[0].planes.size(), last_solve_.observations,
                  last_solve_.last_cost, change);
    line(text);
    Show("joint adjustment", round);
    progress(std::min(0.95, (round + 1.0) / (kLeastRounds + 2)));
    converged_ = many && change < kStandsStill;
    if (converged_ && round + 1 >= kLeastRounds) break;
    // The map has settled once the noise has: then all points take part.
    if (change < 1.0 || round + 1 >= kLeastRounds - 1) many_points_ = true;
    ++rounds_;
    if (rounds_ < kMostRounds) after_round();
  }
  MeasureCorrelation(line);
}

RefinementProgress Refinement::Checkpoint() const {
  return {state_, problem_.imu_sigma, noise_, rounds_, many_points_, {}};
}

void Refinement::Restore(const RefinementProgress& progress) {
  state_ = progress.state;
  problem_.imu_sigma = progress.imu_sigma;
  noise_ = progress.noise;
  rounds_ = progress.rounds;
  many_points_ = progress.many_points;
}

void Refinement::MeasureCorrelation(const Line& line) {
  correlation_ = CorrelationFactor(problem_.planes, state_);
  char text[120];
  std::snprintf(text, sizeof(text), "points share errors: sigmas grow by a factor of %.2f",
                std::sqrt(correlation_));
  line(text);
}

double Refinement::ChangeInSigmas(const CalibrationState& before) const {
  if (last_solve_.information.size() == 0) return 1e9;
  const ObservabilityAnalysis analysis = Analyze();
  double largest = 0.0;
  for (std::size_t l = 0; l < state_.lidars.size(); ++l) {
    const PoseSigma& sigma = analysis.sigmas[l];
    const Eigen::Vector3d rotation =
        Log(state_.lidars[l].T_imu_sensor.rotation * before.lidars[l].T_imu_sensor.rotation.conjugate());
    const Eigen::Vector3d translation =
        state_.lidars[l].T_imu_sensor.translation - before.lidars[l].T_imu_sensor.translation;
    largest = std::max(largest, rotation.cwiseQuotient(sigma.rotation).cwiseAbs().maxCoeff());
    largest = std::max(largest, translation.cwiseQuotient(sigma.translation).cwiseAbs().maxCoeff());
    largest = std::max(
        largest, std::abs(state_.lidars[l].time_offset - before.lidars[l].time_offset) / sigma.time_offset);
  }
  return largest;
}

ObservabilityAnalysis Refinement::Analyze() const {
  const double residuals = static_cast<double>(
      std::max<std::size_t>(1, last_solve_.observations + 2 * last_solve_.landmark_observations));
  const double scatter = std::max(1.0, last_solve_.last_cost / (residuals + 6.0 * ImuSampleCount(dataset_)));
  return AnalyzeCalibration(problem_, state_, last_solve_.information / (scatter * correlation_));
}

void Refinement::Show(const std::string& stage, int iteration) {
  const ObservabilityAnalysis analysis =
      last_solve_.information.size() > 0 ? Analyze() : ObservabilityAnalysis();
  observer_.OnSnapshot(MakeSnapshot(stage, iteration, rig_, dataset_, state_, problem_.planes[0],
                                    analysis.sigmas, last_solve_.last_cost));
}

}  // namespace mlic
