#pragma once

#include <ceres/cost_function.h>
#include <ceres/problem.h>

#include <memory>
#include <vector>

#include "ceres_reference/blocks.h"
#include "ceres_reference/manifolds.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/layout.h"

namespace mlic::ceres_reference {

// One block of the calibration and the columns of its tangent space in the calibration vector of Layout.
struct CalibrationBlock {
  double* data;
  int ambient, tangent;
  int column;
  PlusFunction plus;  // null: plain vectors
};

// All of the calibration, in order of the columns.
std::vector<CalibrationBlock> CalibrationBlocks(EvaluationPoint* at, const Layout& layout);

// Sets the calibration's manifolds, which must outlive the problem, and what is fixed: whole blocks, of plain
// vectors single elements. free: for each column.
std::vector<std::unique_ptr<CeresManifold>> SetCalibrationManifolds(
    const std::vector<CalibrationBlock>& blocks, const std::vector<bool>& free, ceres::Problem* problem);

// CalibrationPrior, priors.cc, as one residual for each column: with information V L V^T and gradient g at
// the state, r = L^-1/2 V^T g with Jacobian L^1/2 V^T (pseudo-inverse). Blocks: all of the calibration.
class PriorCost : public ceres::CostFunction {
 public:
  PriorCost(const JointProblem& problem, EvaluationPoint* at, const Layout& layout, BlockList* list);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const JointProblem& problem_;
  const EvaluationPoint& at_;
  const Layout& layout_;
  std::vector<CalibrationBlock> blocks_;
};

}  // namespace mlic::ceres_reference
