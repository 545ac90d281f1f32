#include "ceres_reference/imu_costs.h"

#include <ceres/loss_function.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/factors/gauge.h"
#include "mlic_core/factors/imu_residual.h"
#include "mlic_core/problem/state.h"

namespace mlic::ceres_reference {
namespace {

constexpr double kImuHuber = 4.0;    // sigmas, as in imu_terms.cc
constexpr double kKnotScale = 1e-3;  // 1/m, 1/rad, as in AddGauge

}  // namespace

ImuCost::ImuCost(EvaluationPoint* at, std::size_t drive, const ImuSample& sample, const ImuSigma& sigma,
                 bool with_matrices, BlockList* blocks)
    : at_(*at),
      drive_(drive),
      sample_(sample),
      sigma_(sigma),
      with_matrices_(with_matrices),
      knots_(at->state.drives[drive].trajectory, sample.time, MeasurementKnots::kClockMargin) {
  DriveState& state = at->state.drives[drive];
  knots_.AddTo(&at->drives[drive], blocks);
  blocks->Add(state.bias.knots[0].data(), Layout::kOfBias);  // constant
  blocks->Add(&at->state.gravity, 1);
  blocks->Add(&at->state.accelerometer_lag, 1);
  blocks->Add(at->state.accelerometer_matrix.data(), 9);
  if (with_matrices) blocks->Add(at->state.gyroscope_matrix.data(), 9);
  *mutable_parameter_block_sizes() = blocks->ambients;
  set_num_residuals(7);
}

bool ImuCost::Evaluate(double const* const*, double* residuals, double** jacobians) const {
  const SplitSpline& trajectory = at_.state.drives[drive_].trajectory;
  const ImuCalibration imu = at_.state.Imu(drive_, sample_.time);
  const double then = sample_.time - imu.accelerometer_lag;
  const ImuBases bases(knots_.rotation.Basis(trajectory.rotation.knots(), sample_.time),
                       knots_.rotation.Basis(trajectory.rotation.knots(), then),
                       knots_.position.Basis(trajectory.position.knots(), then));
  ImuResidual::Jacobian J;
  const Eigen::Matrix<double, 6, 1> r = ImuResidual::Evaluate(trajectory, bases, imu, at_.state.Gravity(),
                                                              sample_, jacobians != nullptr ? &J : nullptr);
  if (jacobians != nullptr) ImuResidual::TurnOne(at_.state.accelerometer_axes, &J);
  const ceres::HuberLoss loss(kImuHuber);
  Eigen::Matrix<double, ImuResidual::kColumns, 7> rows;
  double remainder = 0.0;
  for (int i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? sigma_.gyroscope[i] : sigma_.accelerometer[i - 3];
    const double square = r[i] * r[i] / (sigma * sigma);
    double rho[3];
    loss.Evaluate(square, rho);
    remainder += rho[0] - rho[1] * square;
    const double scale = std::sqrt(rho[1]) / sigma;
    residuals[i] = scale * r[i];
    if (jacobians != nullptr) rows.col(i) = scale * J.col(i);
  }
  residuals[6] = std::sqrt(std::max(0.0, remainder));
  if (jacobians == nullptr) return true;
  rows.col(6).setZero();
  knots_.rotation.Write(rows.leftCols<3>(), 0, bases.rates, 4, jacobians);
  knots_.rotation.Write(rows.rightCols<4>(), 0, bases.rotation, 4, jacobians, 3);
  knots_.position.Write(rows, ImuResidual::kPosition, bases.position, 3, jacobians + knots_.rotation.count);
  double** rest = jacobians + knots_.Count();
  WriteBlock(rows, ImuResidual::kBias, Layout::kOfBias, Layout::kOfBias, rest[0]);
  WriteBlock(rows, ImuResidual::kGravity, 1, 1, rest[1]);
  WriteBlock(rows, ImuResidual::kLag, 1, 1, rest[2]);
  if (!with_matrices_) {
    WriteBlock(rows, ImuResidual::kAlignment, 3, 9, rest[3]);
    return true;
  }
  WriteBlock(rows, ImuResidual::kAlignment, 9, 9, rest[3]);
  WriteBlock(rows, ImuResidual::kMatrices + 6, 6, 9, rest[4]);
  return true;
}

GaugeCost::GaugeCost(EvaluationPoint* at, std::size_t drive, BlockList* blocks)
    : at_(*at),
      drive_(drive),
      knots_(at->state.drives[drive].trajectory, at->state.drives[drive].trajectory.Start(), 0.0) {
  knots_.AddTo(&at->drives[drive], blocks);
  *mutable_parameter_block_sizes() = blocks->ambients;
  set_num_residuals(4);
}

bool GaugeCost::Evaluate(double const* const*, double* residuals, double** jacobians) const {
  std::fill_n(residuals, 4, 0.0);
  if (jacobians == nullptr) return true;
  const SplitSpline& trajectory = at_.state.drives[drive_].trajectory;
  const double start = trajectory.Start();
  const SplineBasis rb = knots_.rotation.Basis(trajectory.rotation.knots(), start);
  const SplineBasis pb = knots_.position.Basis(trajectory.position.knots(), start);
  const GaugeResidual::Jacobian J = GaugeResidual::JacobianAtZero(trajectory, rb, pb);
  knots_.Write(J.topRows<GaugeResidual::kSensor>().eval(), rb, pb, jacobians);
  return true;
}

KnotCost::KnotCost(int ambient) {
  mutable_parameter_block_sizes()->push_back(ambient);
  set_num_residuals(3);
}

bool KnotCost::Evaluate(double const* const*, double* residuals, double** jacobians) const {
  std::fill_n(residuals, 3, 0.0);
  if (jacobians == nullptr) return true;
  WriteBlock(Eigen::Matrix3d(kKnotScale * Eigen::Matrix3d::Identity()), 0, 3, parameter_block_sizes()[0],
             jacobians[0]);
  return true;
}

}  // namespace mlic::ceres_reference
