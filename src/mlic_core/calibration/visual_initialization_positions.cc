#include "mlic_core/calibration/visual_initialization_positions.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "mlic_core/calibration/visual_initialization_sights.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/imu/imu_samples.h"
#include "mlic_core/imu/robust.h"

namespace mlic {
namespace {

constexpr double kGravityKnots = 10.0;     // s
constexpr double kDrift = 5e-4;            // rad/s, of the gyro frame: what the bias is still off by
constexpr double kLongestTrack = 3.0;      // s; longer ones are cut, which keeps the band narrow
constexpr double kBiasSigma = 0.2;         // m/s^2, prior
constexpr double kLeastForceSigma = 0.02;  // m/s^2: rotations are not exact
constexpr int kRounds = 12;
constexpr int kConvexRounds = 5;

// Where the unknowns stand: control points of all drives in order of time; then gravity knots and bias of
// each drive, then lever arms.
struct Unknowns {
  std::vector<UniformKnots> knots;                 // of each drive
  std::vector<int> first_knot;                     // scalar, of each drive
  std::vector<int> gravity;                        // first scalar of each drive's, in the border
  std::vector<std::vector<double>> gravity_times;  // of each drive
  std::vector<int> bias, lever;                    // in the border
  int knot_scalars = 0, border = 0, bandwidth = 0;

  explicit Unknowns(const KnownRotations& known) {
    for (std::size_t d = 0; d < known.gyro.size(); ++d) {
      const double start = known.gyro[d].Start(), end = known.gyro[d].End();
      knots.push_back(UniformKnots::Covering(start, end, known.knot_spacing[d]));
      first_knot.push_back(knot_scalars);
      knot_scalars += 3 * knots.back().count;
      const int reach = static_cast<int>(std::ceil(kLongestTrack / known.knot_spacing[d])) + 5;
      bandwidth = std::max(bandwidth, 3 * std::min(reach, knots.back().count));
      const int parts = std::max(1, static_cast<int>(std::lround((end - start) / kGravityKnots)));
      gravity_times.emplace_back();
      for (int i = 0; i <= parts; ++i) gravity_times.back().push_back(start + (end - start) * i / parts);
      gravity.push_back(border);
      border += 3 * (parts + 1);
      bias.push_back(border);
      border += 3;
    }
    for (std::size_t c = 0; c < known.cameras.size(); ++c) {
      lever.push_back(border);
      border += 3;
    }
    bandwidth = std::min(bandwidth, knot_scalars - 1);
  }

  // The two gravity knots about a time and the share of the second.
  void GravityAt(std::size_t drive, double time, int* first, double* share) const {
    const std::vector<double>& times = gravity_times[drive];
    const double length = times[1] - times[0];
    const int last = static_cast<int>(times.size()) - 2;
    const int i = std::clamp(static_cast<int>((time - times[0]) / length), 0, last);
    *first = gravity[drive] + 3 * i;
    *share = (time - times[i]) / length;
  }
};

// One linear measurement of three components: residual = sum of blocks * unknowns - value.
struct LinearRow {
  int knot = 0;               // scalar of the first of four control points
  Eigen::Vector4d weights;    // of them
  int border[3];              // scalars of border blocks
  Eigen::Matrix3d blocks[3];  // their coefficients
  int border_count = 0;
};

void AddRow(const LinearRow& row, const Eigen::Matrix3d& W, const Eigen::Vector3d& value, Accumulator* sum) {
  // H += J^T W J, g -= J^T W value (unknowns are solved for, not steps).
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j <= i; ++j) {
      sum->AddBand(row.knot + 3 * i, row.knot + 3 * j, row.weights[i] * row.weights[j] * W);
    }
    sum->gradient_knots.segment<3>(row.knot + 3 * i) -= row.weights[i] * (W * value);
  }
  for (int b = 0; b < row.border_count; ++b) {
    const Eigen::Matrix3d left = row.blocks[b].transpose() * W;
    for (int i = 0; i < 4; ++i) {
      sum->border.block<3, 3>(row.border[b], row.knot + 3 * i) += row.weights[i] * left;
    }
    for (int c = 0; c < row.border_count; ++c) {
      sum->corner.block<3, 3>(row.border[b], row.border[c]) += left * row.blocks[c];
    }
    sum->gradient_calibration.segment<3>(row.border[b]) -= left * value;
  }
}

class PositionSolver {
 public:
  PositionSolver(const KnownRotations& known)
      : known_(known), unknowns_(known), sights_(CollectSights(known, kLongestTrack)) {
    knots_ = Eigen::VectorXd::Zero(unknowns_.knot_scalars);
    border_ = Eigen::VectorXd::Zero(unknowns_.border);
    for (const ImuSigma& sigma : known.imu_sigma) {
      force_sigma_.push_back(std::max(kLeastForceSigma, 2.0 * sigma.accelerometer));
    }
  }

  bool Solve(const CancellationToken& cancellation, VisualPositions* result) {
    for (int round = 0; round < kRounds; ++round) {
      cancellation.ThrowIfCancelled();
      sum_ = Accumulator(unknowns_.knot_scalars, unknowns_.bandwidth, unknowns_.border);
      AddForces();
      AddSights();
      AddPriors(round >= 2);
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

  LinearRow ForceRow(std::size_t d, double time, const Eigen::Matrix3d& R) const {
    LinearRow row;
    const SplineBasis basis(unknowns_.knots[d], time);
    row.knot = unknowns_.first_knot[d] + 3 * basis.first;
    row.weights = SplineBasis::Weights(basis.lambda_ddot);
    double share;
    unknowns_.GravityAt(d, time, &row.border[0], &share);
    row.border[1] = row.border[0] + 3;
    row.border[2] = unknowns_.bias[d];
    row.blocks[0] = -(1.0 - share) * Eigen::Matrix3d::Identity();
    row.blocks[1] = -share * Eigen::Matrix3d::Identity();
    row.blocks[2] = R;
    row.border_count = 3;
    return row;
  }

  void AddForces() {
    double squares = 0.0, count = 0.0;
    for (std::size_t d = 0; d < known_.gyro.size(); ++d) {
      const double weight = 1.0 / (force_sigma_[d] * force_sigma_[d]);
      for (const ImuSample& sample : OrderedFiniteSamples(known_.dataset->drives[d].imu)) {
        const Eigen::Matrix3d R = known_.gyro[d].RotationTo(sample.time).toRotationMatrix();
        const LinearRow row = ForceRow(d, sample.time, R);
        const Eigen::Vector3d value = R * sample.specific_force;
        AddRow(row, weight * Eigen::Matrix3d::Identity(), value, &sum_);
        Eigen::Vector3d residual = -value;
        for (int i = 0; i < 4; ++i) residual += row.weights[i] * knots_.segment<3>(row.knot + 3 * i);
        for (int b = 0; b < 3; ++b) residual += row.blocks[b] * border_.segment<3>(row.border[b]);
        squares += residual.squaredNorm();
        count += 3.0;
      }
    }
    force_rms_ = std::sqrt(squares / std::max(1.0, count));
  }

  LinearRow SightRow(const SightedPoint& point, const Sight& sight) const {
    LinearRow row;
    const SplineBasis basis(unknowns_.knots[point.drive], sight.time);
    row.knot = unknowns_.first_knot[point.drive] + 3 * basis.first;
    row.weights = SplineBasis::Weights(basis.lambda);
    row.border[0] = unknowns_.lever[sight.camera];
    row.blocks[0] = sight.rotation;
    row.border_count = 1;
    return row;
  }

  static Eigen::Matrix3d WeightOf(const Sight& sight) {
    const double sigma = sight.sigma * sight.distance;
    return sight.weight / (sigma * sigma) *
           (Eigen::Matrix3d::Identity() - sight.direction * sight.direction.transpose());
  }

  // Inverse of the point's own block; along the rays of points without parallax next to nothing.
  static Eigen::Matrix3d PointCovariance(const SightedPoint& point) {
    Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
    for (const Sight& sight : point.sights) own += WeightOf(sight);
    own.diagonal().array() += 1e-7 * own.trace() + 1e-12;
    return own.inverse();
  }

  void AddSights() {
    constexpr std::size_t kChunks = 8;
    std::vector<Accumulator> parts(
        kChunks, Accumulator(unknowns_.knot_scalars, unknowns_.bandwidth, unknowns_.border));
    ParallelChunks(sights_.size(), kChunks, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) AddPoint(sights_[p], &parts[chunk]);
    });
    for (const Accumulator& part : parts) sum_ += part;
  }

  // W_i c_i^2 terms of each sight, less what the free point takes out: -(W_i c_i) own^-1 (W_j c_j).
  void AddPoint(const SightedPoint& point, Accumulator* sum) const {
    const std::size_t n = point.sights.size();
    const Eigen::Matrix3d covariance = PointCovariance(point);
    std::vector<LinearRow> rows(n);
    std::vector<Eigen::Matrix3d> W(n);
    std::vector<int> columns;  // control points, first scalars, ascending
    for (std::size_t i = 0; i < n; ++i) {
      rows[i] = SightRow(point, point.sights[i]);
      W[i] = WeightOf(point.sights[i]);
      AddRow(rows[i], W[i], Eigen::Vector3d::Zero(), sum);
      for (int k = 0; k < 4; ++k) columns.push_back(rows[i].knot + 3 * k);
    }
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    std::vector<Eigen::Matrix3d> ties(columns.size(), Eigen::Matrix3d::Zero());  // unknowns x point
    std::vector<Eigen::Matrix3d> levers(known_.cameras.size(), Eigen::Matrix3d::Zero());
    for (std::size_t i = 0; i < n; ++i) {
      const auto at = std::lower_bound(columns.begin(), columns.end(), rows[i].knot) - columns.begin();
      for (int k = 0; k < 4; ++k) ties[at + k] += rows[i].weights[k] * W[i];
      levers[point.sights[i].camera] += rows[i].blocks[0].transpose() * W[i];
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Eigen::Matrix3d left = ties[i] * covariance;
      for (std::size_t j = 0; j <= i; ++j) {
        sum->AddBand(columns[i], columns[j], -left * ties[j].transpose());
      }
    }
    for (std::size_t c = 0; c < levers.size(); ++c) {
      if (levers[c].isZero(0.0)) continue;
      const Eigen::Matrix3d left = levers[c] * covariance;
      for (std::size_t j = 0; j < columns.size(); ++j) {
        sum->border.block<3, 3>(unknowns_.lever[c], columns[j]) -= left * ties[j].transpose();
      }
      for (std::size_t e = 0; e < levers.size(); ++e) {
        sum->corner.block<3, 3>(unknowns_.lever[c], unknowns_.lever[e]) -= left * levers[e].transpose();
      }
    }
  }

  void AddPriors(bool with_gravity_length) {
    for (std::size_t d = 0; d < known_.gyro.size(); ++d) {
      // The first position is zero; nothing is farther than some kilometres.
      sum_.band.row(0).segment(unknowns_.first_knot[d], 3 * unknowns_.knots[d].count).array() += 1e-8;
      sum_.band.row(0).segment(unknowns_.first_knot[d] + 3, 3).array() += 1e8;
      sum_.corner.diagonal().segment<3>(unknowns_.bias[d]).array() += 1.0 / (kBiasSigma * kBiasSigma);
      const std::size_t count = unknowns_.gravity_times[d].size();
      const double length = unknowns_.gravity_times[d][1] - unknowns_.gravity_times[d][0];
      const double drift = 1.0 / std::pow(9.81 * kDrift * length, 2);
      for (std::size_t i = 0; i < count; ++i) {
        const int at = unknowns_.gravity[d] + 3 * static_cast<int>(i);
        sum_.corner.diagonal().segment<3>(at).array() += 1e-4;
        if (i > 0) {
          sum_.corner.diagonal().segment<3>(at).array() += drift;
          sum_.corner.diagonal().segment<3>(at - 3).array() += drift;
          for (int a = 0; a < 3; ++a) {
            sum_.corner(at + a, at - 3 + a) -= drift;
            sum_.corner(at - 3 + a, at + a) -= drift;
          }
        }
        if (!with_gravity_length) continue;
        constexpr double kLengthWeight = 1e6;
        const Eigen::Vector3d down = border_.segment<3>(at).normalized();
        sum_.corner.block<3, 3>(at, at) += kLengthWeight * down * down.transpose();
        sum_.gradient_calibration.segment<3>(at) -= kLengthWeight * kGravity.norm() * down;
      }
    }
    for (std::size_t c = 0; c < known_.cameras.size(); ++c) {
      const Eigen::Vector3d information = known_.guesses[c].sigma_translation.array().square().inverse();
      sum_.corner.diagonal().segment<3>(unknowns_.lever[c]) += information;
      sum_.gradient_calibration.segment<3>(unknowns_.lever[c]) -=
          information.cwiseProduct(known_.guesses[c].T_imu_sensor.translation);
    }
  }

  // Points by the positions found, then distances and robust weights by the points.
  void MovePoints(bool redescending) {
    std::vector<std::vector<double>> errors(sights_.size());
    ParallelFor(sights_.size(), [&](std::size_t p) {
      SightedPoint& point = sights_[p];
      std::vector<Eigen::Vector3d> centres;
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      for (const Sight& sight : point.sights) {
        const LinearRow row = SightRow(point, sight);
        Eigen::Vector3d centre = row.blocks[0] * border_.segment<3>(row.border[0]);
        for (int k = 0; k < 4; ++k) centre += row.weights[k] * knots_.segment<3>(row.knot + 3 * k);
        centres.push_back(centre);
        right += WeightOf(sight) * centre;
      }
      const Eigen::Vector3d position = PointCovariance(point) * right;
      for (std::size_t i = 0; i < centres.size(); ++i) {
        Sight& sight = point.sights[i];
        const Eigen::Vector3d ray = position - centres[i];
        const double range = ray.norm(), along = sight.direction.dot(ray);
        constexpr double kNearest = 0.05;  // m
        sight.distance = std::max(kNearest, range);
        const double error = along > 0.0 ? ray.cross(sight.direction).norm() / sight.distance : 1.0;
        errors[p].push_back(error / sight.sigma);
      }
    });
    std::vector<double> all;
    for (const auto& of_point : errors) all.insert(all.end(), of_point.begin(), of_point.end());
    constexpr double kMedianOfNorm = 1.1774;  // of a standard normal 2-vector
    const double sigma = std::max(0.25, Median(all) / kMedianOfNorm);
    std::size_t inliers = 0;
    for (std::size_t p = 0; p < sights_.size(); ++p) {
      for (std::size_t i = 0; i < errors[p].size(); ++i) {
        const double error = errors[p][i];
        const double weight = redescending ? TukeyWeight(error, sigma) : AbsoluteWeight(error, sigma);
        sights_[p].sights[i].weight = weight / (sigma * sigma);
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
    const double misfit = std::max(1.0, force_rms_ / force_sigma_[d]);
    return misfit * std::sqrt(std::max(0.0, variance));
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
      for (const SightedPoint& point : sights_) {
        if (point.drive != d) continue;
        drive.start = std::min(drive.start, point.sights.front().time);
        drive.end = std::max(drive.end, point.sights.back().time);
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
  const Unknowns unknowns_;
  std::vector<SightedPoint> sights_;
  std::vector<double> force_sigma_;  // of each drive, m/s^2
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
