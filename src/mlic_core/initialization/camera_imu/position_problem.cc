#include "mlic_core/initialization/camera_imu/position_problem.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/bias_prior.h"

namespace mlic {
namespace {

constexpr double kGravityKnots = 10.0;  // s; from: measured, with kPart (camera_imu.cc)
// from: measured, with kPart (camera_imu.cc).
constexpr double kDrift = 5e-4;  // rad/s, of the gyro frame: what the bias is still off by
constexpr double kHeld = 1e12;   // (m/s^2)^-2, information of what is held; from: guard, beyond all samples'
constexpr double kAcceleration = 30.0;  // m/s^2; from: guard, beyond what rigs are moved by

// No rig accelerates by more than some g. Samples that end just after a knot, and those that are missing,
// leave control points to nothing else: free, they are kilometres off, and the equations have no solution.
void AddAccelerations(const UniformKnots& knots, int first, Accumulator* sum) {
  const Eigen::Vector3d weights = Eigen::Vector3d(1.0, -2.0, 1.0) / (knots.spacing * knots.spacing);
  const double information = 1.0 / (kAcceleration * kAcceleration);
  for (int k = 0; k + 2 < knots.count; ++k) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) {
        sum->AddBand(first + 3 * (k + i), first + 3 * (k + j),
                     weights[i] * weights[j] * information * Eigen::Matrix3d::Identity());
      }
    }
  }
}

}  // namespace

PositionUnknowns::PositionUnknowns(const KnownRotations& known, double longest) {
  for (std::size_t d = 0; d < known.gyro.size(); ++d) {
    const double start = known.gyro[d].Start(), end = known.gyro[d].End();
    knots.push_back(UniformKnots::Covering(start, end, known.knot_spacing[d]));
    first_knot.push_back(knot_scalars);
    knot_scalars += 3 * knots.back().count;
    const int reach = static_cast<int>(std::ceil(longest / known.knot_spacing[d])) + 5;
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

void PositionUnknowns::GravityAt(std::size_t drive, double time, int* first, double* share) const {
  const std::vector<double>& times = gravity_times[drive];
  const double length = times[1] - times[0];
  const int last = static_cast<int>(times.size()) - 2;
  const int i = std::clamp(static_cast<int>((time - times[0]) / length), 0, last);
  *first = gravity[drive] + 3 * i;
  *share = (time - times[i]) / length;
}
Eigen::Vector3d LinearRow::Of(const Eigen::VectorXd& knots, const Eigen::VectorXd& border_values) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i) sum += weights[i] * knots.segment<3>(knot + 3 * i);
  for (int b = 0; b < border_count; ++b) sum += blocks[b] * border_values.segment<3>(border[b]);
  return sum;
}

LinearRow ForceRow(const PositionUnknowns& unknowns, std::size_t d, double time, const Eigen::Matrix3d& R) {
  LinearRow row;
  const SplineBasis basis(unknowns.knots[d], time);
  row.knot = unknowns.first_knot[d] + 3 * basis.first;
  row.weights = SplineBasis::Weights(basis.lambda_ddot);
  double share;
  unknowns.GravityAt(d, time, &row.border[0], &share);
  row.border[1] = row.border[0] + 3;
  row.border[2] = unknowns.bias[d];
  row.blocks[0] = -(1.0 - share) * Eigen::Matrix3d::Identity();
  row.blocks[1] = -share * Eigen::Matrix3d::Identity();
  row.blocks[2] = R;
  row.border_count = 3;
  return row;
}

LinearRow ObservationRow(const PositionUnknowns& unknowns, const PointObservations& point,
                         const DirectionObservation& observation) {
  LinearRow row;
  const SplineBasis basis(unknowns.knots[point.drive], observation.time);
  row.knot = unknowns.first_knot[point.drive] + 3 * basis.first;
  row.weights = SplineBasis::Weights(basis.lambda);
  row.border[0] = unknowns.lever[observation.camera];
  row.blocks[0] = observation.rotation;
  row.border_count = 1;
  return row;
}

Eigen::Matrix3d WeightOf(const DirectionObservation& observation) {
  const double sigma = observation.sigma * observation.distance;
  return observation.weight / (sigma * sigma) *
         (Eigen::Matrix3d::Identity() - observation.ray * observation.ray.transpose());
}

Eigen::Vector3d OffsetOf(const DirectionObservation& observation) {
  return observation.distance * observation.direction;
}

Eigen::Matrix3d PointCovariance(const PointObservations& point) {
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  for (const DirectionObservation& observation : point.observations) own += WeightOf(observation);
  own.diagonal().array() += 1e-7 * own.trace() + 1e-12;
  return own.inverse();
}

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

// W_i c_i^2 terms of each observation, less what the free point takes out: -(W_i c_i) own^-1 (W_j c_j).
void AddPoint(const PositionUnknowns& unknowns, const PointObservations& point, Accumulator* sum) {
  const std::size_t n = point.observations.size();
  const Eigen::Matrix3d covariance = PointCovariance(point);
  std::vector<LinearRow> rows(n);
  std::vector<Eigen::Matrix3d> W(n);
  std::vector<int> columns;  // control points, first scalars, ascending
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    W[i] = WeightOf(point.observations[i]);
    right += W[i] * OffsetOf(point.observations[i]);
  }
  const Eigen::Vector3d offset = covariance * right;
  for (std::size_t i = 0; i < n; ++i) {
    rows[i] = ObservationRow(unknowns, point, point.observations[i]);
    AddRow(rows[i], W[i], offset - OffsetOf(point.observations[i]), sum);
    for (int k = 0; k < 4; ++k) columns.push_back(rows[i].knot + 3 * k);
  }
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  std::vector<Eigen::Matrix3d> couplings(columns.size(), Eigen::Matrix3d::Zero());  // unknowns x point
  std::vector<Eigen::Matrix3d> levers(unknowns.lever.size(), Eigen::Matrix3d::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    const auto at = std::lower_bound(columns.begin(), columns.end(), rows[i].knot) - columns.begin();
    for (int k = 0; k < 4; ++k) couplings[at + k] += rows[i].weights[k] * W[i];
    levers[point.observations[i].camera] += rows[i].blocks[0].transpose() * W[i];
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Eigen::Matrix3d left = couplings[i] * covariance;
    for (std::size_t j = 0; j <= i; ++j) {
      sum->AddBand(columns[i], columns[j], -left * couplings[j].transpose());
    }
  }
  for (std::size_t c = 0; c < levers.size(); ++c) {
    if (levers[c].isZero(0.0)) continue;
    const Eigen::Matrix3d left = levers[c] * covariance;
    for (std::size_t j = 0; j < columns.size(); ++j) {
      sum->border.block<3, 3>(unknowns.lever[c], columns[j]) -= left * couplings[j].transpose();
    }
    for (std::size_t e = 0; e < levers.size(); ++e) {
      sum->corner.block<3, 3>(unknowns.lever[c], unknowns.lever[e]) -= left * levers[e].transpose();
    }
  }
}

void AddPriors(const PositionUnknowns& unknowns, const KnownRotations& known, const Eigen::VectorXd* gravity,
               Accumulator* sum) {
  for (std::size_t d = 0; d < known.gyro.size(); ++d) {
    // The first position is zero; nothing is farther than some kilometres.
    sum->band.row(0).segment(unknowns.first_knot[d], 3 * unknowns.knots[d].count).array() += 1e-8;
    sum->band.row(0).segment(unknowns.first_knot[d] + 3, 3).array() += 1e8;
    AddAccelerations(unknowns.knots[d], unknowns.first_knot[d], sum);
    // Gravity of any length and a bias look alike in a drive that hardly tilts: one waits for the other.
    sum->corner.diagonal().segment<3>(unknowns.bias[d]).array() +=
        gravity != nullptr ? 1.0 / (kAccelerometerBiasSigma * kAccelerometerBiasSigma) : kHeld;
    const std::size_t count = unknowns.gravity_times[d].size();
    const double length = unknowns.gravity_times[d][1] - unknowns.gravity_times[d][0];
    const double drift = 1.0 / std::pow(9.81 * kDrift * length, 2);
    for (std::size_t i = 0; i < count; ++i) {
      const int at = unknowns.gravity[d] + 3 * static_cast<int>(i);
      sum->corner.diagonal().segment<3>(at).array() += 1e-4;
      if (i > 0) {
        sum->corner.diagonal().segment<3>(at).array() += drift;
        sum->corner.diagonal().segment<3>(at - 3).array() += drift;
        for (int a = 0; a < 3; ++a) {
          sum->corner(at + a, at - 3 + a) -= drift;
          sum->corner(at - 3 + a, at + a) -= drift;
        }
      }
      if (gravity == nullptr) continue;
      constexpr double kLengthWeight = 1e6;  // from: guard, as good as held
      const Eigen::Vector3d down = gravity->segment<3>(at).normalized();
      sum->corner.block<3, 3>(at, at) += kLengthWeight * down * down.transpose();
      sum->gradient_calibration.segment<3>(at) -= kLengthWeight * kGravity.norm() * down;
    }
  }
  for (std::size_t c = 0; c < known.cameras.size(); ++c) {
    const Eigen::Vector3d information = known.guesses[c].sigma_translation.array().square().inverse();
    sum->corner.diagonal().segment<3>(unknowns.lever[c]) += information;
    sum->gradient_calibration.segment<3>(unknowns.lever[c]) -=
        information.cwiseProduct(known.guesses[c].T_imu_sensor.translation);
  }
}

}  // namespace mlic
