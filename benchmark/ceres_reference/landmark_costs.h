#pragma once

#include <ceres/cost_function.h>

#include "ceres_reference/blocks.h"

namespace mlic::ceres_reference {

// The two whitened residuals (Reprojection) of one observation of a point; Ceres applies the loss. Zero where
// the trajectory does not reach, 100 sigmas without a Jacobian where the camera cannot see the point. Blocks:
// control points, extrinsic rotation and translation, time offset, readout (rolling shutters only),
// intrinsics, point.
class ReprojectionCost : public ceres::CostFunction {
 public:
  ReprojectionCost(EvaluationPoint* at, std::size_t drive, const LandmarkObservation& observation,
                   double* point, BlockList* blocks);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const EvaluationPoint& at_;
  std::size_t drive_;
  const LandmarkObservation& observation_;
  Reprojection factor_;
  MeasurementKnots knots_;
};

// The three whitened residuals (LidarPointResidual) of a point that a LiDAR measured; no loss. Zero where the
// trajectory does not reach. Blocks: control points, extrinsic rotation and translation, time offset, point.
class LidarPointCost : public ceres::CostFunction {
 public:
  LidarPointCost(EvaluationPoint* at, std::size_t drive, const LidarPointObservation& observation,
                 double* point, BlockList* blocks);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const EvaluationPoint& at_;
  std::size_t drive_;
  const LidarPointObservation& observation_;
  MeasurementKnots knots_;
};

}  // namespace mlic::ceres_reference
