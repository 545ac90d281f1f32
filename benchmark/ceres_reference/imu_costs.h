#pragma once

#include <ceres/cost_function.h>

#include "ceres_reference/blocks.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic::ceres_reference {

// The six whitened residuals (ImuResidual) of one sample, each with Huber's loss beyond 4 sigma as in
// imu_terms.cc. A loss of Ceres would take all six together, so they come weighted: component i is
// sqrt(w) r with w = rho'(r^2), its Jacobian sqrt(w) J, and a seventh residual without a Jacobian makes up
// the sum of rho(r^2) - w r^2. So cost, gradient and Gauss-Newton matrix are those of the loss of each.
// Blocks: control points, gyroscope bias, accelerometer bias, gravity, the accelerometer's lag and matrix
// and, where estimated, the gyroscope's.
class ImuCost : public ceres::CostFunction {
 public:
  ImuCost(EvaluationPoint* at, std::size_t drive, const ImuSample& sample, const ImuSigma& sigma,
          bool with_matrices, BlockList* blocks);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const EvaluationPoint& at_;
  std::size_t drive_;
  const ImuSample& sample_;
  const ImuSigma& sigma_;
  bool with_matrices_;
  MeasurementKnots knots_;
};

// The IMU's position and yaw in the map at the trajectory's start: rows without a residual, so that a step
// leaves them where they are. AddGauge fixes a sensor's yaw, which is another gauge of the same minimum.
// Blocks: control points.
class GaugeCost : public ceres::CostFunction {
 public:
  GaugeCost(EvaluationPoint* at, std::size_t drive, BlockList* blocks);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const EvaluationPoint& at_;
  std::size_t drive_;
  MeasurementKnots knots_;
};

// The little that keeps one control point from wandering where it has next to no data (AddGauge).
class KnotCost : public ceres::CostFunction {
 public:
  explicit KnotCost(int ambient);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;
};

}  // namespace mlic::ceres_reference
