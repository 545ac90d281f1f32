#include "mlic_core/uncertainty/observability.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/inverse_in_limits.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/sensors/observability_limits.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"
#include "mlic_core/uncertainty/pair_jacobian.h"

namespace mlic {
namespace {

// Marks axes and directions of one 3-vector quantity. Returns the one that is shown least.
ObservabilityAnalysis::LeastShown Judge(const Eigen::Matrix3d& data_covariance,
                                        const Eigen::Matrix3d& covariance, double limit,
                                        const Eigen::Vector3d* guess_sigma,
                                        UnobservableDirection::Quantity quantity, std::array<bool, 3>* axes,
                                        std::vector<UnobservableDirection>* directions) {
  const auto limit_along = [&](const Eigen::Vector3d& direction) {
    if (guess_sigma == nullptr) return limit;
    return std::min(limit, direction.cwiseProduct(*guess_sigma).norm());
  };
  ObservabilityAnalysis::LeastShown least;
  const auto look = [&](const Eigen::Vector3d& direction, double sigma) {
    const double along = limit_along(direction);
    // Also where the sigma is not a number.
    if (!(sigma * least.limit <= least.sigma * along)) least = {sigma, along};
    return sigma <= along;
  };
  // An axis that lies a little along a direction which stands at the guess errs by that little of the guess.
  constexpr double kOfGuess = 2.0;  // sigmas; from: derivation, its 95 percent interval
  Eigen::Matrix3d with_held = data_covariance;
  const SymmetricEigen<3> eigen(data_covariance);
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d direction = eigen.eigenvectors().col(i);
    if (look(direction, std::sqrt(std::max(0.0, eigen.eigenvalues()[i])))) continue;
    if (guess_sigma != nullptr) {
      double variance = (kOfGuess * direction.cwiseProduct(*guess_sigma)).squaredNorm();
      // Rotations are not held: the data keep theirs nearer than the guess where they know better.
      if (quantity == UnobservableDirection::Quantity::kRotation) {
        variance = std::min(variance, eigen.eigenvalues()[i]);
      }
      with_held += (variance - eigen.eigenvalues()[i]) * direction * direction.transpose();
    }
    int largest;
    direction.cwiseAbs().maxCoeff(&largest);
    if (direction[largest] < 0.0) direction = -direction;
    directions->push_back({quantity, direction, std::sqrt(direction.dot(covariance * direction))});
  }
  for (int a = 0; a < 3; ++a) {
    (*axes)[a] = look(Eigen::Vector3d::Unit(a), std::sqrt(with_held(a, a)));
  }
  return least;
}

// With combinations of the sensors' translations held at the guesses (rows), the rest follows what is wrong
// with these: the covariance given each of them, and what their own covariance adds.
Eigen::MatrixXd WithHeld(const Eigen::MatrixXd& covariance, const std::vector<Eigen::VectorXd>& held,
                         const Eigen::VectorXd& guess_variances) {
  if (held.empty()) return covariance;
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(held.size()), held[0].size());
  for (std::size_t i = 0; i < held.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = held[i].transpose();
  const Eigen::MatrixXd of_rows = covariance.leftCols(rows.cols()) * rows.transpose();
  const Eigen::MatrixXd variance = rows * of_rows.topRows(rows.cols());
  const Eigen::MatrixXd follows = SolveSymmetric(variance, of_rows.transpose()).transpose();
  const Eigen::MatrixXd of_guess = rows * guess_variances.asDiagonal() * rows.transpose();
  return covariance - follows * of_rows.transpose() + follows * of_guess * follows.transpose();
}

struct SensorGuess {
  std::optional<ExtrinsicGuess> guess;
  bool fixed = false;  // given, and does not move
};

// What the covariances of all sensors are made of.
struct SensorInformation {
  Eigen::MatrixXd data;               // information of the calibration (Layout) without the guesses
  Eigen::MatrixXd solved;             // the same with all that the solve held taken as known
  Eigen::MatrixXd guess;              // what the guesses add
  std::vector<SensorGuess> sensors;   // of each LiDAR, then of each camera
  std::vector<Eigen::VectorXd> held;  // JointProblem::held_translations
  Eigen::VectorXd limits;             // steps that count as large
};

// Sensors that are given are known: to a thousandth of the limits. Their clocks do not drift (Layout).
Eigen::MatrixXd WithFixedSensors(const SensorInformation& given, Eigen::MatrixXd data) {
  for (std::size_t l = 0; l < given.sensors.size(); ++l) {
    if (!given.sensors[l].fixed) continue;
    for (int i = Layout::Sensor(l); i < Layout::Sensor(l + 1); ++i) {
      data(i, i) += 1e6 / (given.limits[i] * given.limits[i]);
    }
  }
  return data;
}

// Of all sensors and of the calibration's other parameters.
ObservabilityAnalysis AnalyzeSensors(const SensorInformation& given, const Inflation& inflation,
                                     double scale) {
  const Eigen::VectorXd& limits = given.limits;
  const std::size_t sensors = given.sensors.size();
  const Eigen::MatrixXd data = WithFixedSensors(given, given.data);
  const Eigen::MatrixXd solved = WithFixedSensors(given, given.solved);
  ObservabilityAnalysis analysis;
  analysis.solved_covariance = InverseInLimits(solved + given.guess, limits);
  Eigen::VectorXd guess_variances = Eigen::VectorXd::Zero(Layout::Sensor(sensors));
  for (std::size_t s = 0; s < sensors; ++s) {
    if (!given.sensors[s].guess) continue;
    guess_variances.segment<3>(Layout::Sensor(s) + 3) = given.sensors[s].guess->sigma_translation.cwiseAbs2();
  }
  const Eigen::MatrixXd inflated = VarianceOfInflation(analysis.solved_covariance, inflation, scale);
  const Eigen::MatrixXd all_covariance =
      WithHeld(InverseInLimits(data + given.guess, limits), given.held, guess_variances) + inflated;
  // Also here that of the guesses: along what only they show, metres would grow for the cameras and not for
  // the LiDARs that go with them, as if their pairs were not known either.
  const Eigen::MatrixXd data_covariance = InverseInLimits(data, limits) + inflated;
  const int poses = Layout::Sensor(sensors);
  analysis.data_covariance = data_covariance.topLeftCorner(poses, poses);
  analysis.whole_covariance = all_covariance;
  analysis.covariance = all_covariance.topLeftCorner(poses, poses);
  analysis.inner_sigmas =
      all_covariance.diagonal().tail(all_covariance.rows() - poses).cwiseMax(0.0).cwiseSqrt();
  for (std::size_t l = 0; l < sensors; ++l) {
    const int at = Layout::Sensor(l);
    const auto& all = analysis.covariance;
    const auto& shown = analysis.data_covariance;
    const std::optional<ExtrinsicGuess>& guess = given.sensors[l].guess;
    ObservabilityAnalysis::Sensor sensor;
    using Quantity = UnobservableDirection::Quantity;
    sensor.least_translation = Judge(shown.block<3, 3>(at + 3, at + 3), all.block<3, 3>(at + 3, at + 3),
                                     kTranslationLimit, guess ? &guess->sigma_translation : nullptr,
                                     Quantity::kTranslation, &sensor.translation, &sensor.directions);
    sensor.least_rotation = Judge(shown.block<3, 3>(at, at), all.block<3, 3>(at, at), kRotationLimit,
                                  guess ? &guess->sigma_rotation : nullptr, Quantity::kRotation,
                                  &sensor.rotation, &sensor.directions);
    PoseSigma sigma;
    sigma.rotation = all.diagonal().segment<3>(at).cwiseSqrt();
    sigma.translation = all.diagonal().segment<3>(at + 3).cwiseSqrt();
    sigma.time_offset = std::sqrt(all(at + 6, at + 6));
    sensor.least_time_offset = {std::sqrt(shown(at + 6, at + 6)), kTimeLimit};
    sensor.time_offset = sensor.least_time_offset.sigma <= kTimeLimit;
    if (!sensor.time_offset) {
      sensor.directions.push_back({Quantity::kTimeOffset, Eigen::Vector3d::Zero(), sigma.time_offset});
    }
    analysis.sensors.push_back(sensor);
    analysis.sigmas.push_back(sigma);
  }
  return analysis;
}

SensorInformation MakeInformation(const JointProblem& problem, const CalibrationState& state,
                                  const Layout& layout, const Eigen::MatrixXd& information) {
  Eigen::MatrixXd prior;
  Eigen::VectorXd gradient;
  CalibrationPrior(problem, state, layout, &prior, &gradient);
  // Priors of biases, matrices and readouts are knowledge about devices and belong to the data; guesses do
  // not.
  const int poses = layout.poses;
  Eigen::MatrixXd guess = Eigen::MatrixXd::Zero(prior.rows(), prior.cols());
  guess.topLeftCorner(poses, poses) = prior.topLeftCorner(poses, poses);
  SensorInformation given;
  for (const LidarTerms& lidar : problem.lidars) given.sensors.push_back({lidar.guess, lidar.fixed});
  std::vector<FixedCameraParameters> held;
  for (const CameraTerms& camera : problem.cameras) {
    held.push_back(camera.fixed);
    given.sensors.push_back(
        {camera.guess, camera.fixed.rotation && camera.fixed.translation && camera.fixed.time_offset});
  }
  given.held = problem.held_translations;
  given.data = WithVarianceOfHeldTerms(information, state, layout, held, prior - guess);
  given.solved = InformationWithFixed(information, state, layout, held) + (prior - guess);
  given.guess = guess;
  given.limits = CalibrationLimits(state, layout);
  return given;
}

}  // namespace

Inflation WithGradient(const Eigen::MatrixXd& by_gradient, Inflation inflation) {
  const auto apply = [&](Eigen::MatrixXd* of_gradient) {
    *of_gradient = by_gradient * *of_gradient * by_gradient.transpose();
  };
  if (!inflation.cameras.IsEmpty()) {
    apply(&inflation.cameras.information);
    apply(&inflation.cameras.self_weighing);
    apply(&inflation.cameras.pattern);
  }
  if (inflation.points.rows() == by_gradient.rows()) apply(&inflation.points);
  return inflation;
}

Eigen::MatrixXd VarianceOfInflation(const Eigen::MatrixXd& covariance, const Inflation& inflation,
                                    double scale) {
  const Eigen::MatrixXd of_cameras = VarianceOfInflation(covariance, inflation.cameras, scale);
  if (inflation.points.rows() != covariance.rows()) return of_cameras;
  return of_cameras + covariance * inflation.points / scale * covariance;
}

FreeAlignment CovarianceWithAlignment(const JointProblem& problem, const CalibrationState& state,
                                      const Eigen::MatrixXd& information, const Eigen::Matrix3d& prior) {
  const Layout layout(state, problem.estimate_imu_matrices);
  const SensorInformation given = MakeInformation(problem, state, layout, information);
  FreeAlignment free;
  for (const SensorGuess& sensor : given.sensors) free.fixed.push_back(sensor.fixed);
  Eigen::MatrixXd data = given.data;
  const int at = layout.alignment;
  data.block<3, 3>(at, at) = information.block<3, 3>(at, at) + prior;
  free.covariance = InverseInLimits(WithFixedSensors(given, std::move(data)), given.limits);
  return free;
}

ObservabilityAnalysis AnalyzeCalibration(const JointProblem& problem, const CalibrationState& state,
                                         const Eigen::MatrixXd& information, const Inflation& inflation,
                                         double scale) {
  const Layout layout(state, problem.estimate_imu_matrices);
  const SensorInformation given = MakeInformation(problem, state, layout, information);
  const int poses = layout.poses;
  ObservabilityAnalysis analysis = AnalyzeSensors(given, inflation, scale);
  for (std::size_t s = 0; s < analysis.sensors.size(); ++s) {
    if (layout.drift[s] < 0) continue;
    analysis.sensors[s].drift_sigma = analysis.inner_sigmas[layout.drift[s] - poses];
  }
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    ObservabilityAnalysis::Intrinsics camera;
    const std::size_t count = state.cameras[c].intrinsics.parameters.size();
    camera.held = problem.cameras[c].fixed.intrinsics;
    camera.held.resize(count, false);
    for (std::size_t i = 0; i < count; ++i) {
      const int at = layout.Intrinsics(c) + static_cast<int>(i) - poses;
      camera.sigmas.push_back(camera.held[i] ? 0.0 : analysis.inner_sigmas[at]);
    }
    if (layout.Readout(c) >= 0) camera.readout_sigma = analysis.inner_sigmas[layout.Readout(c) - poses];
    analysis.cameras.push_back(camera);
  }
  return analysis;
}

Eigen::Matrix<double, 7, 7> PairCovariance(const SensorCalibration& a, const SensorCalibration& b,
                                           const Eigen::Matrix<double, 14, 14>& covariance) {
  const Eigen::Matrix<double, 7, 14> J = PairJacobian(a, b);
  return J * covariance * J.transpose();
}

PairResult MakePair(const SensorCalibration& a, const SensorCalibration& b,
                    const Eigen::Matrix<double, 14, 14>& covariance) {
  PairResult pair;
  pair.T_a_b = a.T_imu_sensor.Inverse() * b.T_imu_sensor;
  const Eigen::Matrix<double, 7, 7> of_pair = PairCovariance(a, b, covariance);
  pair.sigma.rotation = of_pair.diagonal().segment<3>(0).cwiseMax(0.0).cwiseSqrt();
  pair.sigma.translation = of_pair.diagonal().segment<3>(3).cwiseMax(0.0).cwiseSqrt();
  pair.sigma.time_offset = std::sqrt(std::max(0.0, of_pair(6, 6)));
  return pair;
}

Eigen::Matrix<double, 14, 14> JointCovariance(const Eigen::MatrixXd& covariance, std::size_t a,
                                              std::size_t b) {
  const int at_a = Layout::Sensor(a), at_b = Layout::Sensor(b);
  Eigen::Matrix<double, 14, 14> both;
  both << covariance.block<7, 7>(at_a, at_a), covariance.block<7, 7>(at_a, at_b),
      covariance.block<7, 7>(at_b, at_a), covariance.block<7, 7>(at_b, at_b);
  return both;
}

std::vector<PoseSigma> SigmasAgainstLidar(const ObservabilityAnalysis& analysis,
                                          const CalibrationState& state, std::size_t lidar) {
  const SensorOrder order = state.Sensors();
  std::vector<PoseSigma> sigmas;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const auto both =
        JointCovariance(analysis.covariance, order.PlaceOf(LidarId(lidar)), order.PlaceOf(CameraId(c)));
    sigmas.push_back(MakePair(state.lidars[lidar], state.cameras[c].sensor, both).sigma);
  }
  return sigmas;
}

}  // namespace mlic
