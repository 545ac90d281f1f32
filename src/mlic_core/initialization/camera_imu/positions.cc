#include "mlic_core/initialization/camera_imu/positions.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/imu/imu_samples.h"
#include "mlic_core/imu/noise_spectrum.h"
#include "mlic_core/imu/robust.h"
#include "mlic_core/initialization/camera_imu/position_problem.h"

namespace mlic {
namespace {

// from: guard, time and memory.
constexpr double kLongestTrack = 3.0;  // s; longer ones are cut, which keeps the band narrow
// from: derivation, gravity turned by 2e-3 rad.
constexpr double kLeastForceSigma = 0.02;  // m/s^2: rotations are not exact
constexpr int kPositionRounds = 12;        // from: guard
constexpr int kConvexRounds = 5;           // from: guard

// from: guard, short enough that a knock leaves the rest of the drive as it is, long enough for a spectrum.
constexpr double kForceWindow = 4.0;  // s

// The specific force of one drive. Its noise is that of a window of time: landing, a bump or a hand that sets
// the rig down shake it for a second, and say nothing of the time before and after.
struct Forces {
  std::vector<ImuSample> samples;
  double rate = 0.0;                       // Hz
  double top = 0.0;                        // Hz, up to where positions go
  std::size_t window = 1;                  // samples
  std::vector<Eigen::Vector3d> sigma;      // m/s^2, along the IMU's axes, of each window
  std::vector<Eigen::Vector3d> residuals;  // along the IMU's axes, of each sample

  // The last one is longer, by what is left.
  std::size_t WindowOf(std::size_t sample) const { return std::min(sample / window, sigma.size() - 1); }
  std::size_t End(std::size_t w) const { return w + 1 < sigma.size() ? (w + 1) * window : samples.size(); }
};

NoiseSpectrum SpectrumOf(const std::vector<Eigen::Vector3d>& signal, const Forces& forces, std::size_t w,
                         int axis) {
  const std::size_t begin = w * forces.window, end = forces.End(w);
  Eigen::VectorXd values(static_cast<Eigen::Index>(end - begin));
  for (std::size_t k = begin; k < end; ++k) values[static_cast<Eigen::Index>(k - begin)] = signal[k][axis];
  return {values, forces.rate};
}

// Sigmas by the noise's density where positions end: vibration above does not move them.
Forces ForcesOf(const KnownRotations& known, std::size_t d) {
  Forces forces;
  forces.samples = OrderedFiniteSamples(known.dataset->drives[d].imu);
  forces.rate = 1.0 / MedianPeriod(forces.samples);
  forces.top = TopOfBand(forces.rate, known.knot_spacing[d]);
  forces.window = std::max<std::size_t>(1, static_cast<std::size_t>(kForceWindow * forces.rate));
  std::vector<Eigen::Vector3d> measured;
  for (const ImuSample& sample : forces.samples) measured.push_back(sample.specific_force);
  forces.sigma.assign(std::max<std::size_t>(1, measured.size() / forces.window),
                      known.imu_sigma[d].accelerometer);
  for (std::size_t w = 0; w < forces.sigma.size(); ++w) {
    for (int a = 0; a < 3; ++a) {
      const double level = SpectrumOf(measured, forces, w, a).WhiteVariance(forces.top, 2.0 * forces.top);
      if (level > 0.0) forces.sigma[w][a] = std::sqrt(level);
    }
    forces.sigma[w] = (2.0 * forces.sigma[w]).cwiseMax(kLeastForceSigma);
  }
  return forces;
}

// By what the forces that are left exceed their sigmas in the band of positions and as far again beyond it,
// by what the windows tell.
double MisfitOf(const Forces& forces) {
  const double top = 2.0 * forces.top, share = std::min(1.0, 2.0 * top / forces.rate);
  double squares = 0.0, all = 0.0;
  for (std::size_t w = 0; w < forces.sigma.size(); ++w) {
    for (int a = 0; a < 3; ++a) {
      const double level = SpectrumOf(forces.residuals, forces, w, a).Variance(0.0, top) / share;
      const double weight = 1.0 / (forces.sigma[w][a] * forces.sigma[w][a]);
      squares += weight * level * weight;
      all += weight;
    }
  }
  return std::max(1.0, std::sqrt(squares / all));
}

class PositionSolver {
 public:
  PositionSolver(const KnownRotations& known)
      : known_(known),
        unknowns_(known, kLongestTrack),
        observations_(CollectObservations(known, kLongestTrack)) {
    knots_ = Eigen::VectorXd::Zero(unknowns_.knot_scalars);
    border_ = Eigen::VectorXd::Zero(unknowns_.border);
    for (std::size_t d = 0; d < known.gyro.size(); ++d) forces_.push_back(ForcesOf(known, d));
  }

  bool Solve(const CancellationToken& cancellation, VisualPositions* result) {
    for (int round = 0; round < kPositionRounds; ++round) {
      cancellation.ThrowIfCancelled();
      sum_ = Accumulator(unknowns_.knot_scalars, unknowns_.bandwidth, unknowns_.border);
      AddForces();
      AddObservations();
      AddPriors(unknowns_, known_, round >= 2 ? &border_ : nullptr, &sum_);
      const NormalSolution solution = SolveFor(sum_);
      if (!solution.solved) return false;
      knots_ = solution.delta.head(unknowns_.knot_scalars);
      border_ = solution.delta.tail(unknowns_.border);
      MovePoints(round + 1 >= kConvexRounds);
    }
    Fill(result);
    return true;
  }

 private:
  NormalSolution SolveFor(const Accumulator& sum) const {
    const Eigen::MatrixXd no_prior = Eigen::MatrixXd::Zero(unknowns_.border, unknowns_.border);
    const Eigen::VectorXd no_gradient = Eigen::VectorXd::Zero(unknowns_.border);
    return SolveNormalEquations(sum, {}, no_prior, no_gradient, std::vector<bool>(unknowns_.border, true),
                                0.0, false);
  }

  void AddForces() {
    double squares = 0.0, count = 0.0;
    for (std::size_t d = 0; d < forces_.size(); ++d) {
      Forces& forces = forces_[d];
      forces.residuals.clear();
      for (std::size_t k = 0; k < forces.samples.size(); ++k) {
        const ImuSample& sample = forces.samples[k];
        const Eigen::Vector3d weights = forces.sigma[forces.WindowOf(k)].cwiseAbs2().cwiseInverse();
        const Eigen::Matrix3d R = known_.gyro[d].RotationTo(sample.time).toRotationMatrix();
        const LinearRow row = ForceRow(unknowns_, d, sample.time, R);
        const Eigen::Vector3d value = R * sample.specific_force;
        AddRow(row, R * weights.asDiagonal() * R.transpose(), value, &sum_);
        forces.residuals.emplace_back(R.transpose() * (row.Of(knots_, border_) - value));
        squares += forces.residuals.back().squaredNorm();
        count += 3.0;
      }
    }
    force_rms_ = std::sqrt(squares / std::max(1.0, count));
  }

  void AddObservations() {
    constexpr std::size_t kChunks = 8;  // from: structural, parts of a sum
    std::vector<Accumulator> parts(
        kChunks, Accumulator(unknowns_.knot_scalars, unknowns_.bandwidth, unknowns_.border));
    ParallelChunks(observations_.size(), kChunks, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) AddPoint(unknowns_, observations_[p], &parts[chunk]);
    });
    for (const Accumulator& part : parts) sum_ += part;
  }

  // Points by the positions found, then distances and robust weights by the points.
  void MovePoints(bool redescending) {
    std::vector<std::vector<double>> errors(observations_.size());
    ParallelFor(observations_.size(), [&](std::size_t p) {
      PointObservations& point = observations_[p];
      std::vector<Eigen::Vector3d> centres;
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      for (const DirectionObservation& observation : point.observations) {
        const Eigen::Vector3d centre = ObservationRow(unknowns_, point, observation).Of(knots_, border_);
        centres.push_back(centre);
        right += WeightOf(observation) * (centre + OffsetOf(observation));
      }
      const Eigen::Vector3d position = PointCovariance(point) * right;
      for (std::size_t i = 0; i < centres.size(); ++i) {
        DirectionObservation& observation = point.observations[i];
        const Eigen::Vector3d ray = position - centres[i];
        const double range = ray.norm(), along = observation.direction.dot(ray);
        constexpr double kNearest = 0.05;  // m; from: guard
        observation.distance = std::max(kNearest, range);
        observation.ray = along > 0.0 ? Eigen::Vector3d(ray / range) : observation.direction;
        const double error =
            along > 0.0 ? ray.cross(observation.direction).norm() / observation.distance : 1.0;
        errors[p].push_back(error / observation.sigma);
      }
    });
    std::vector<double> all;
    for (const auto& of_point : errors) all.insert(all.end(), of_point.begin(), of_point.end());
    constexpr double kMedianOfNorm = 1.1774;  // of a standard normal 2-vector; from: derivation
    const double sigma = std::max(0.25, Median(all) / kMedianOfNorm);
    std::size_t inliers = 0;
    for (std::size_t p = 0; p < observations_.size(); ++p) {
      for (std::size_t i = 0; i < errors[p].size(); ++i) {
        const double error = errors[p][i];
        const double weight = redescending ? TukeyWeight(error, sigma) : AbsoluteWeight(error, sigma);
        observations_[p].observations[i].weight = weight / (sigma * sigma);
        inliers += error < 4.0 * sigma;
      }
    }
    inlier_share_ = static_cast<double>(inliers) / static_cast<double>(std::max<std::size_t>(1, all.size()));
  }

  // Relative sigma of the extent of one drive's positions about their mean.
  double ScaleSigma(std::size_t d) const {
    const int count = unknowns_.knots[d].count, first = unknowns_.first_knot[d];
    Eigen::VectorXd extent = Eigen::VectorXd::Zero(unknowns_.knot_scalars);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (int j = 0; j < count; ++j) mean += knots_.segment<3>(first + 3 * j) / count;
    for (int j = 0; j < count; ++j)
      extent.segment<3>(first + 3 * j) = knots_.segment<3>(first + 3 * j) - mean;
    const Eigen::VectorXd functional = extent / std::max(1e-12, extent.squaredNorm());
    Accumulator system = sum_;
    system.gradient_knots = -functional;
    system.gradient_calibration.setZero();
    const NormalSolution solution = SolveFor(system);
    if (!solution.solved) return 1e3;
    const double variance = functional.dot(solution.delta.head(unknowns_.knot_scalars));
    return MisfitOf(forces_[d]) * std::sqrt(std::max(0.0, variance));
  }

  void Fill(VisualPositions* result) const {
    for (std::size_t d = 0; d < known_.gyro.size(); ++d) {
      DrivePositions drive;
      std::vector<Eigen::Vector3d> control_points;
      for (int j = 0; j < unknowns_.knots[d].count; ++j) {
        control_points.push_back(knots_.segment<3>(unknowns_.first_knot[d] + 3 * j));
      }
      drive.positions = PositionSpline(unknowns_.knots[d], control_points);
      drive.gravity_times = unknowns_.gravity_times[d];
      drive.start = known_.gyro[d].End();
      drive.end = known_.gyro[d].Start();
      for (const PointObservations& point : observations_) {
        if (point.drive != d) continue;
        drive.start = std::min(drive.start, point.observations.front().time);
        drive.end = std::max(drive.end, point.observations.back().time);
      }
      for (std::size_t i = 0; i < drive.gravity_times.size(); ++i) {
        drive.gravity.push_back(border_.segment<3>(unknowns_.gravity[d] + 3 * static_cast<int>(i)));
      }
      drive.accelerometer_bias = border_.segment<3>(unknowns_.bias[d]);
      result->drives.push_back(drive);
      result->scale_sigma = std::max(result->scale_sigma, ScaleSigma(d));
    }
    for (const int lever : unknowns_.lever) result->lever_arms.push_back(border_.segment<3>(lever));
    result->accelerometer_rms = force_rms_;
    result->inlier_share = inlier_share_;
  }

  const KnownRotations& known_;
  const PositionUnknowns unknowns_;
  std::vector<PointObservations> observations_;
  std::vector<Forces> forces_;  // of each drive
  Eigen::VectorXd knots_, border_;
  Accumulator sum_{0, 0, 0};
  double force_rms_ = 0.0, inlier_share_ = 0.0;
};

}  // namespace

VisualPositions SolvePositions(const KnownRotations& known, const CancellationToken& cancellation) {
  VisualPositions result;
  PositionSolver solver(known);
  if (!solver.Solve(cancellation, &result)) {
    result.failure =
        "positions and scale could not be solved for: too few points are seen from several places";
  }
  return result;
}

}  // namespace mlic
