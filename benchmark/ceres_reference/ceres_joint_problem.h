#pragma once

#include <ceres/ceres.h>

#include <memory>
#include <vector>

#include "ceres_reference/calibration_blocks.h"
#include "mlic_core/problem/joint_problem.h"

namespace mlic::ceres_reference {

struct SolveOptions {
  ceres::LinearSolverType linear_solver = ceres::SPARSE_SCHUR;
  int threads = 1;
  int iterations = 50;
  ceres::IterationCallback* after_iteration = nullptr;  // sees State() as of the last accepted step
};

// The joint problem (joint_problem.h) stated to Ceres: residuals and Jacobians come from the same factors,
// perturbations are those of Layout, MovePlane and MovePoint, losses and priors those of the own solver, and
// points are cut by time in the same way. So both have the same minimum and, there, the same normal matrix:
// Ceres weighs rows of a loss with a negative second derivative, as Huber's, by the root of its first alone,
// which is what the own solver does. Poses that a trajectory is drawn to, and fixed trajectories, serve the
// initialisation only and are refused.
class CeresJointProblem {
 public:
  // given.dataset must outlive this.
  CeresJointProblem(const JointProblem& given, const CalibrationState& start);

  ceres::Solver::Summary Solve(const SolveOptions& options);

  const CalibrationState& State();  // where the solve is
  const Layout& layout() const { return layout_; }

  // Of the calibration (Layout), priors included; zeros for what is fixed. Throws where Ceres finds the
  // normal matrix singular.
  Eigen::MatrixXd Covariance(int threads);

 private:
  void AddLandmarks(std::size_t drive);
  void AddTrajectory(std::size_t drive);
  void Add(ceres::CostFunction* cost, ceres::LossFunction* loss, const BlockList& blocks);

  JointProblem given_;
  Layout layout_;
  std::vector<bool> free_;
  EvaluationPoint at_;
  std::vector<CalibrationBlock> calibration_;
  ceres::HuberLoss huber_;
  LiftedManifold rotation_, plane_, point_;
  std::vector<std::unique_ptr<CeresManifold>> calibration_manifolds_;
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace mlic::ceres_reference
