#pragma once

#include <ceres/cost_function.h>

#include "ceres_reference/blocks.h"

namespace mlic::ceres_reference {

// The whitened residual (PointToPlane) of one point tied to a plane; Ceres applies the loss. Zero where the
// trajectory does not reach. Blocks: control points, extrinsic rotation and translation, time offset, plane.
class PlaneCost : public ceres::CostFunction {
 public:
  PlaneCost(EvaluationPoint* at, std::size_t drive, const PlaneObservation& observation, double* plane,
            BlockList* blocks);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const EvaluationPoint& at_;
  std::size_t drive_;
  const PlaneObservation& observation_;
  MeasurementKnots knots_;
};

}  // namespace mlic::ceres_reference
