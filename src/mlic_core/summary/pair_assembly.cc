#include "mlic_core/summary/pair_assembly.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/sensors/observability_limits.h"
#include "mlic_core/summary/result_assembly.h"
#include "mlic_core/summary/sigmas_in_use.h"
#include "mlic_core/summary/snapshot.h"

namespace mlic {
namespace {

using Quantity = UnobservableDirection::Quantity;
using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

// A pair that is known worse than this along some direction, guesses and clocks included, is not given: a
// ruler does as well.
constexpr double kWorstRotation = 2.0 * M_PI / 180.0;  // rad; from: definition
constexpr double kWorstTranslation = 0.3;              // m; from: definition

// Directions of one quantity that the data do not show to the limit, with the sigma that is then claimed.
void AddUnobservable(const Eigen::Matrix3d& from_data, const Eigen::Matrix3d& claimed, double limit,
                     Quantity quantity, std::vector<UnobservableDirection>* directions) {
  const SymmetricEigen<3> eigen(from_data);
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
  return std::sqrt(SymmetricEigen<3>(covariance).eigenvalues()[2]);
}

// With its names and what it does not show; nothing where it is hardly known.
std::optional<PairResult> IfKnown(PairResult pair, const Matrix7d& claimed, const Matrix7d& shown) {
  // False also where a number is none.
  const bool known = Worst(claimed.block<3, 3>(0, 0)) < kWorstRotation &&
                     Worst(claimed.block<3, 3>(3, 3)) < kWorstTranslation;
  if (!known) return std::nullopt;
  AddUnobservable(shown.block<3, 3>(3, 3), claimed.block<3, 3>(3, 3), kTranslationLimit,
                  Quantity::kTranslation, &pair.unobservable);
  AddUnobservable(shown.block<3, 3>(0, 0), claimed.block<3, 3>(0, 0), kRotationLimit, Quantity::kRotation,
                  &pair.unobservable);
  if (!(shown(6, 6) <= kTimeLimit * kTimeLimit)) {
    pair.unobservable.push_back({Quantity::kTimeOffset, Eigen::Vector3d::Zero(), pair.sigma.time_offset});
  }
  return pair;
}

const std::string& NameAt(const Rig& rig, std::size_t place) {
  return place < rig.lidars.size() ? rig.lidars[place].name : rig.cameras[place - rig.lidars.size()].name;
}

// Of the sensors at two places of the order.
std::optional<PairResult> PairOf(const LidarsAlone& alone, const CalibrationState& state,
                                 const ObservabilityAnalysis& analysis, std::size_t a, std::size_t b) {
  const SensorOrder order = state.Sensors();
  const SensorCalibration& of_a = state.Sensor(order.At(a));
  const SensorCalibration& of_b = state.Sensor(order.At(b));
  const auto joint = JointCovariance(analysis.covariance, a, b);
  PairResult pair = MakePair(of_a, of_b, joint);
  pair.a = NameAt(alone.rig, a);
  pair.b = NameAt(alone.rig, b);
  const Eigen::Matrix3d axes_of_root =
      state.Sensor(order.At(alone.root)).T_imu_sensor.rotation.conjugate().toRotationMatrix();
  pair.in_use = SigmasOfPair(state, analysis, a, b, axes_of_root);
  // Of a parked vehicle the rounds hold the offsets.
  if (alone.parked) {
    pair.sigma.time_offset = std::hypot(alone.time_offset_sigmas[a], alone.time_offset_sigmas[b]);
  }
  return IfKnown(std::move(pair), PairCovariance(of_a, of_b, joint),
                 PairCovariance(of_a, of_b, JointCovariance(analysis.data_covariance, a, b)));
}

// Frees the offset of a camera that was solved with it held: it is known to sigma, and where the camera then
// is, to the guess. error: ErrorOfOffset. Moves pose and offset; variance of the offset, s^2.
double FreeOffset(const std::optional<ExtrinsicGuess>& guess, double sigma, const Vector7d& error,
                  SensorCalibration* camera) {
  if (!guess) return sigma * sigma;
  const RigidTransform& T = camera->T_imu_sensor;
  Eigen::Matrix<double, 6, 1> off, weights;
  off << Log(T.rotation * guess->T_imu_sensor.rotation.conjugate()),
      T.translation - guess->T_imu_sensor.translation;
  weights << guess->sigma_rotation.cwiseAbs2().cwiseInverse(),
      guess->sigma_translation.cwiseAbs2().cwiseInverse();
  const Eigen::Matrix<double, 6, 1> weighted = weights.cwiseProduct(error.head<6>());
  const double variance = 1.0 / (1.0 / (sigma * sigma) + weighted.dot(error.head<6>()));
  const Vector7d move = -variance * weighted.dot(off) * error;
  camera->T_imu_sensor = {(ExpQuaternion(move.head<3>()) * T.rotation).normalized(),
                          T.translation + move.segment<3>(3)};
  camera->time_offset += move[6];
  return variance;
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
  convergence.limit = kLargestChangeOfPairs;
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

bool AllPassed(const std::vector<QualityCheck>& checks) {
  return std::all_of(checks.begin(), checks.end(), [](const QualityCheck& check) { return check.Passed(); });
}

}  // namespace

Eigen::Matrix<double, 7, 1> ErrorOfOffset(const SplitSpline& T_map_root,
                                          const RigidTransform& T_root_camera) {
  constexpr int kSteps = 50;  // from: structural
  // Of the trajectory, that is left out at either end, where hardly a scan holds it. from: guard
  constexpr double kEnd = 0.1;
  const double span = T_map_root.End() - T_map_root.Start();
  const double start = T_map_root.Start() + kEnd * span, step = (1.0 - 2.0 * kEnd) * span / kSteps;
  Eigen::Vector3d turn = Eigen::Vector3d::Zero(), shift = Eigen::Vector3d::Zero();
  for (int k = 0; k < kSteps; ++k) {
    const double t = start + k * step;
    const RigidTransform move = T_map_root.Pose(t).Inverse() * T_map_root.Pose(t + step);
    turn += Log(move.rotation) / (kSteps * step);
    shift += move.translation / (kSteps * step);
  }
  Vector7d error;
  error << turn, shift + turn.cross(T_root_camera.translation), -1.0;
  return error;
}

std::vector<PairResult> MakeCameraPairs(const LidarsAlone& alone, const Adjustment& adjustment) {
  constexpr double kNothingKnown = 1.0;  // s, of an offset; from: definition, the search of a drive's
  CalibrationState state = adjustment.state;
  ObservabilityAnalysis analysis = Analyze(adjustment, alone.dataset);
  const std::size_t lidars = state.lidars.size(), sensors = state.Sensors().size();
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    SensorCalibration& camera = state.cameras[c].sensor;
    const Vector7d error = ErrorOfOffset(state.drives[0].trajectory, camera.T_imu_sensor);
    const double variance =
        FreeOffset(alone.rig.cameras[c].guess, alone.time_offset_sigmas[lidars + c], error, &camera);
    const auto at = static_cast<Eigen::Index>(7 * (lidars + c));
    analysis.covariance.block<7, 7>(at, at) += variance * error * error.transpose();
    analysis.data_covariance.block<7, 7>(at, at) += kNothingKnown * kNothingKnown * error * error.transpose();
  }
  std::vector<PairResult> pairs;
  for (std::size_t a = 0; a < sensors; ++a) {
    for (std::size_t b = std::max(a + 1, lidars); b < sensors; ++b) {
      if (a < lidars && !alone.tied[a]) continue;
      const auto pair = PairOf(alone, state, analysis, a, b);
      if (pair) pairs.push_back(*pair);
    }
  }
  return pairs;
}

std::optional<PairResult> MakeStillPair(const LidarsAlone& alone, std::size_t camera,
                                        const CameraPlace& place) {
  const double sigma = alone.time_offset_sigmas[alone.rig.lidars.size() + camera];
  PairResult pair;
  pair.a = alone.rig.lidars[alone.root].name;
  pair.b = alone.rig.cameras[camera].name;
  pair.T_a_b = place.T_root_camera;
  pair.sigma.rotation = place.claimed.diagonal().head<3>().cwiseSqrt();
  pair.sigma.translation = place.claimed.diagonal().tail<3>().cwiseSqrt();
  pair.sigma.time_offset = sigma;
  // What stands still shows nothing of clocks.
  const auto with_time = [](const Eigen::Matrix<double, 6, 6>& pose, double time_variance) {
    Matrix7d covariance = Matrix7d::Zero();
    covariance.topLeftCorner<6, 6>() = pose;
    covariance(6, 6) = time_variance;
    return covariance;
  };
  return IfKnown(pair, with_time(place.claimed, sigma * sigma),
                 with_time(place.shown, std::numeric_limits<double>::infinity()));
}

std::vector<PairResult> MakeLidarPairs(const LidarsAlone& alone, const Adjustment& adjustment) {
  const ObservabilityAnalysis analysis = Analyze(adjustment, alone.dataset);
  std::vector<PairResult> pairs;
  for (std::size_t a = 0; a < alone.tied.size(); ++a) {
    for (std::size_t b = a + 1; b < alone.tied.size(); ++b) {
      if (!alone.tied[a] || !alone.tied[b]) continue;
      const auto pair = PairOf(alone, adjustment.state, analysis, a, b);
      if (pair) pairs.push_back(*pair);
    }
  }
  return pairs;
}

std::vector<PairResult> PairsOfRefused(const Adjustment* whole, const CalibrationResult& result) {
  if (whole == nullptr || !(whole->rounds.last_change < kLargestChangeOfPairs)) return {};
  std::vector<PairResult> pairs = result.pairs;
  for (PairResult& pair : pairs) {
    if (pair.sigma.time_offset <= kTimeLimit) continue;
    pair.unobservable.push_back({Quantity::kTimeOffset, Eigen::Vector3d::Zero(), pair.sigma.time_offset});
  }
  return pairs;
}

std::optional<std::string> RootOf(const Rig& rig, const std::vector<PairResult>& pairs,
                                  const std::string& preferred) {
  std::optional<std::string> root;
  std::ptrdiff_t most = 0;
  for (const LidarConfig& lidar : rig.lidars) {
    const auto has = [&](const PairResult& pair) { return Has(pair, lidar.name); };
    const std::ptrdiff_t count = std::count_if(pairs.begin(), pairs.end(), has);
    if (count > most || (count > 0 && count == most && lidar.name == preferred)) root = lidar.name;
    most = std::max(most, count);
  }
  return root;
}

bool TieAll(const Rig& rig, const std::string& root, const std::vector<PairResult>& pairs) {
  const auto tied = [&](const auto& sensor) {
    return sensor.name == root || std::any_of(pairs.begin(), pairs.end(), [&](const PairResult& pair) {
             return Has(pair, root) && Has(pair, sensor.name);
           });
  };
  return std::all_of(rig.lidars.begin(), rig.lidars.end(), tied) &&
         std::all_of(rig.cameras.begin(), rig.cameras.end(), tied);
}

bool CanGivePairs(const Adjustment& adjustment) { return AllPassed(MakePairChecks(adjustment)); }

void AssemblePairs(const Rig& rig, const std::string& root, const Adjustment& adjustment,
                   std::vector<PairResult> pairs, CalibrationResult* result) {
  const std::vector<QualityCheck> checks = MakePairChecks(adjustment);
  result->checks.insert(result->checks.end(), checks.begin(), checks.end());
  const auto with_root = [&](const PairResult& pair) { return Has(pair, root); };
  if (!AllPassed(checks) || std::none_of(pairs.begin(), pairs.end(), with_root)) return;
  result->verdict = Verdict::kPartial;
  result->pairs = std::move(pairs);
  result->root = root;
  result->guesses = GuessesOf(rig);
  CompleteRejected(rig, result);
}

}  // namespace mlic
