#include "mlic_core/solver/small_fit.h"

#include <ceres/cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <utility>

#include "mlic_core/solver/ceres_compatibility.h"

namespace mlic {
namespace {

// Relative fall of the cost and relative step that are rounding: the last of a quadratically converging
// solve.
constexpr double kCostTolerance = 1e-14;  // from: guard
constexpr double kStepTolerance = 1e-12;  // from: guard

class FunctionCost : public ceres::CostFunction {
 public:
  FunctionCost(int rows, SmallFit::Residual residual, const std::vector<SmallFit::Block>& blocks)
      : residual_(std::move(residual)) {
    set_num_residuals(rows);
    for (const SmallFit::Block& block : blocks) mutable_parameter_block_sizes()->push_back(block.size);
  }

  bool Evaluate(double const* const* blocks, double* r, double** jacobians) const override {
    return residual_(blocks, r, jacobians);
  }

 private:
  SmallFit::Residual residual_;
};

}  // namespace

SmallFit::SmallFit() : problem_(std::make_unique<ceres::Problem>()) {}

SmallFit::~SmallFit() = default;

void SmallFit::SetRotation(Eigen::Quaterniond* rotation) {
  SetQuaternionManifold(problem_.get(), rotation->coeffs().data());
  rotations_.push_back(rotation->coeffs().data());
}

void SmallFit::Add(int rows, Residual residual, const std::vector<Block>& blocks, double huber) {
  std::vector<double*> values;
  for (const Block& block : blocks) values.push_back(block.values);
  Add(new FunctionCost(rows, std::move(residual), blocks), values, huber);
}

void SmallFit::Add(ceres::CostFunction* cost, const std::vector<double*>& blocks, double huber) {
  problem_->AddResidualBlock(cost, huber > 0.0 ? new ceres::HuberLoss(huber) : nullptr, blocks);
}

SmallFitSummary SmallFit::Solve(int most_iterations) {
  ceres::Solver::Options options;
  options.max_num_iterations = most_iterations;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;
  options.function_tolerance = kCostTolerance;
  options.parameter_tolerance = kStepTolerance;
  options.gradient_tolerance = 0.0;  // has units; the two above have none
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem_.get(), &summary);
  SmallFitSummary out;
  out.usable = summary.IsSolutionUsable();
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  out.iterations = static_cast<int>(summary.iterations.size());
  out.cost = 2.0 * summary.final_cost;
  return out;
}

Eigen::MatrixXd SmallFit::Information(const std::vector<double*>& blocks) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = blocks;
  ceres::CRSMatrix jacobian;
  problem_->Evaluate(options, nullptr, nullptr, nullptr, &jacobian);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(jacobian.num_cols, jacobian.num_cols);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    for (int i = jacobian.rows[row]; i < jacobian.rows[row + 1]; ++i) {
      for (int k = jacobian.rows[row]; k < jacobian.rows[row + 1]; ++k) {
        information(jacobian.cols[i], jacobian.cols[k]) += jacobian.values[i] * jacobian.values[k];
      }
    }
  }
  // Ceres' tangent of a quaternion is half of the rotation.
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(jacobian.num_cols);
  int column = 0;
  for (const double* block : blocks) {
    const bool is_rotation = std::find(rotations_.begin(), rotations_.end(), block) != rotations_.end();
    const int size = is_rotation ? 3 : problem_->ParameterBlockSize(block);
    if (is_rotation) scale.segment<3>(column).setConstant(0.5);
    column += size;
  }
  return scale.asDiagonal() * information * scale.asDiagonal();
}

Eigen::Matrix<double, 3, 4> LeftPerturbationJacobian(const Eigen::Quaterniond& q) {
  // delta = 2 vec(dq * conjugate(q))
  Eigen::Matrix<double, 3, 4> J;
  J << q.w(), -q.z(), q.y(), -q.x(),  //
      q.z(), q.w(), -q.x(), -q.y(),   //
      -q.y(), q.x(), q.w(), -q.z();
  return 2.0 * J;
}

}  // namespace mlic
