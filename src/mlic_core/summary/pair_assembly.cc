#include "mlic_core/summary/pair_assembly.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/problem/observability_limits.h"
#include "mlic_core/summary/snapshot.h"

namespace mlic {
namespace {

using Quantity = UnobservableDirection::Quantity;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

// A pair that is known worse than this along some direction, guesses and clocks included, is not given: a
// ruler does as well.
constexpr double kWorstRotation = 2.0 * M_PI / 180.0;  // rad; from: definition
constexpr double kWorstTranslation = 0.3;              // m; from: definition

// Directions of one quantity that the data do not show to the limit, with the sigma that is then claimed.
void AddUnobservable(const Eigen::Matrix3d& from_data, const Eigen::Matrix3d& claimed, double limit,
                     Quantity quantity, std::vector<UnobservableDirection>* directions) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(from_data);
  for (int i = 0; i < 3; ++i) {
    if (eigen.eigenvalues()[i] <= limit * limit) continue;
    Eigen::Vector3d direction = eigen.eigenvectors().col(i);
    int largest;
    direction.cwiseAbs().maxCoeff(&largest);
    if (direction[largest] < 0.0) direction = -direction;
    directions->push_back({quantity, direction, std::sqrt(direction.dot(claimed * direction))});
  }
}

// Largest sigma along any direction.
double Worst(const Eigen::Matrix3d& covariance) {
  return std::sqrt(
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly).eigenvalues()[2]);
}

std::vector<PairResult> MakePairs(const LidarsAlone& alone, const Adjustment& adjustment,
                                  const ObservabilityAnalysis& analysis) {
  const std::vector<SensorCalibration>& lidars = adjustment.state.lidars;
  std::vector<PairResult> pairs;
  for (std::size_t a = 0; a < lidars.size(); ++a) {
    for (std::size_t b = a + 1; b < lidars.size(); ++b) {
      if (!alone.tied[a] || !alone.tied[b]) continue;
      const auto joint = JointCovariance(analysis.covariance, a, b);
      const Matrix7d claimed = PairCovariance(lidars[a], lidars[b], joint);
      const Matrix7d shown =
          PairCovariance(lidars[a], lidars[b], JointCovariance(analysis.data_covariance, a, b));
      // False also where a number is none.
      const bool known = Worst(claimed.block<3, 3>(0, 0)) < kWorstRotation &&
                         Worst(claimed.block<3, 3>(3, 3)) < kWorstTranslation;
      if (!known) continue;
      PairResult pair = MakePair(lidars[a], lidars[b], joint);
      pair.a = alone.rig.lidars[a].name;
      pair.b = alone.rig.lidars[b].name;
      // Of a parked vehicle the rounds hold the offsets.
      if (alone.parked) {
        pair.sigma.time_offset = std::hypot(alone.time_offset_sigmas[a], alone.time_offset_sigmas[b]);
      }
      AddUnobservable(shown.block<3, 3>(3, 3), claimed.block<3, 3>(3, 3), kTranslationLimit,
                      Quantity::kTranslation, &pair.unobservable);
      AddUnobservable(shown.block<3, 3>(0, 0), claimed.block<3, 3>(0, 0), kRotationLimit, Quantity::kRotation,
                      &pair.unobservable);
      if (!(shown(6, 6) <= kTimeLimit * kTimeLimit)) {
        pair.unobservable.push_back({Quantity::kTimeOffset, Eigen::Vector3d::Zero(), pair.sigma.time_offset});
      }
      pairs.push_back(pair);
    }
  }
  return pairs;
}

// Every LiDAR and camera that has no reason yet gets one, and all get their frames.
void CompleteRejected(const Rig& rig, CalibrationResult* result) {
  std::vector<RejectedSensor>& rejected = result->rejected;
  const auto complete = [&](const auto& config, SensorResult::Type type) {
    bool known = false;
    for (RejectedSensor& sensor : rejected) {
      if (sensor.name != config.name) continue;
      known = true;
      sensor.frame_id = config.frame_id.empty() ? config.name : config.frame_id;
    }
    if (known) return;
    rejected.push_back({config.name, type, config.name + ": nothing in the drive ties it to the IMU",
                        config.frame_id.empty() ? config.name : config.frame_id});
  };
  for (const LidarConfig& lidar : rig.lidars) complete(lidar, SensorResult::Type::kLidar);
  for (const CameraConfig& camera : rig.cameras) complete(camera, SensorResult::Type::kCamera);
}

std::vector<QualityCheck> MakePairChecks(const Adjustment& adjustment) {
  QualityCheck convergence;
  convergence.name = "pairs_convergence";
  convergence.value = adjustment.rounds.last_change;
  convergence.limit = 3.0;  // from: definition, sigmas contain what the last round moved
  convergence.unit = "sigma";
  convergence.remedy = "record a longer drive among more structure";
  QualityCheck planes;
  planes.name = "pairs_planes";
  planes.value = static_cast<double>(adjustment.problem.drives[0].planes.planes.size());
  planes.limit = 20.0;  // from: definition, as of the whole
  planes.unit = "planes";
  planes.bound = QualityCheck::Bound::kLeast;
  planes.remedy = "record near buildings or in a furnished hall";
  return {convergence, planes};
}

}  // namespace

void AssemblePairs(const Rig& rig, const LidarsAlone& alone, const Adjustment& adjustment,
                   CalibrationResult* result) {
  bool good = true;
  for (const QualityCheck& check : MakePairChecks(adjustment)) {
    result->checks.push_back(check);
    good = good && check.Passed();
  }
  if (!good) return;
  std::vector<PairResult> pairs = MakePairs(alone, adjustment, Analyze(adjustment, alone.dataset));
  const std::string& root = rig.lidars[alone.root].name;
  const auto with_root = [&](const PairResult& pair) { return pair.a == root || pair.b == root; };
  if (std::none_of(pairs.begin(), pairs.end(), with_root)) return;
  result->verdict = Verdict::kPartial;
  result->pairs = std::move(pairs);
  result->root = root;
  CompleteRejected(rig, result);
}

}  // namespace mlic
