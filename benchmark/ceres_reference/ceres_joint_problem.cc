#include "ceres_reference/ceres_joint_problem.h"

#include <algorithm>
#include <stdexcept>

#include "ceres_reference/comparison.h"
#include "ceres_reference/imu_costs.h"
#include "ceres_reference/landmark_costs.h"
#include "ceres_reference/plane_cost.h"
#include "mlic_core/common/error.h"
#include "mlic_core/problem/joint_solver.h"

namespace mlic::ceres_reference {
namespace {

constexpr double kHuber = 2.0;  // sigmas, as in linear_terms.h

ceres::Problem::Options ProblemOptions(EvaluationPoint* at) {
  ceres::Problem::Options options;
  options.evaluation_callback = at;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  KeepManifolds(&options);
  options.disable_all_safety_checks = true;  // blocks are distinct and sizes right by construction
  return options;
}

}  // namespace

CeresJointProblem::CeresJointProblem(const JointProblem& given, const CalibrationState& start)
    : given_(WithPointsCut(given, start)),
      layout_(start, given.estimate_imu_matrices),
      free_(FreeCalibration(given_, layout_)),
      at_(start, given_.drives),
      calibration_(CalibrationBlocks(&at_, layout_)),
      huber_(kHuber),
      rotation_(4, 3, PlusRight),
      plane_(7, 3, PlusPlane),
      point_(6, 3, PlusPoint),
      problem_(std::make_unique<ceres::Problem>(ProblemOptions(&at_))) {
  const bool poses = std::any_of(given.drives.begin(), given.drives.end(),
                                 [](const DriveTerms& drive) { return !drive.poses.T_map_imu.empty(); });
  Check(!poses && !given.fix_trajectory, "Ceres reference: states the joint adjustment only");
  for (std::size_t d = 0; d < start.drives.size(); ++d) {
    AddLandmarks(d);
    AddTrajectory(d);
  }
  BlockList blocks;
  auto* prior = new PriorCost(given_, &at_, layout_, &blocks);
  Add(prior, nullptr, blocks);
  calibration_manifolds_ = SetCalibrationManifolds(calibration_, free_, problem_.get());
}

void CeresJointProblem::Add(ceres::CostFunction* cost, ceres::LossFunction* loss, const BlockList& blocks) {
  problem_->AddResidualBlock(cost, loss, blocks.pointers);
}

void CeresJointProblem::AddLandmarks(std::size_t d) {
  const PlaneAssociation& association = given_.drives[d].planes;
  for (std::size_t p = 0; p < association.planes.size(); ++p) {
    double* plane = at_.drives[d].planes[p].data();
    for (std::size_t k = association.begin[p]; k < association.begin[p + 1]; ++k) {
      BlockList blocks;
      auto* cost = new PlaneCost(&at_, d, association.observations[k], plane, &blocks);
      Add(cost, &huber_, blocks);
    }
    SetManifold(problem_.get(), plane, &plane_);
  }
  const LandmarkSet& set = given_.drives[d].landmarks;
  for (std::size_t p = 0; p < set.points.size(); ++p) {
    double* point = at_.drives[d].points[p].data();
    for (std::size_t k = set.begin[p]; k < set.begin[p + 1]; ++k) {
      BlockList blocks;
      auto* cost = new ReprojectionCost(&at_, d, set.observations[k], point, &blocks);
      Add(cost, &huber_, blocks);
    }
    if (set.IsOnMap(p)) {
      BlockList blocks;
      auto* cost = new LidarPointCost(&at_, d, set.lidar_points[p], point, &blocks);
      Add(cost, nullptr, blocks);
    }
    SetManifold(problem_.get(), point, &point_);
  }
}

void CeresJointProblem::AddTrajectory(std::size_t d) {
  const SplitSpline& trajectory = at_.state.drives[d].trajectory;
  for (const ImuSample& sample : given_.dataset->drives[d].imu) {
    if (!trajectory.Contains(sample.time)) continue;
    BlockList blocks;
    auto* cost =
        new ImuCost(&at_, d, sample, given_.drives[d].imu_sigma.usual, given_.estimate_imu_matrices, &blocks);
    Add(cost, nullptr, blocks);
  }
  BlockList blocks;
  auto* gauge = new GaugeCost(&at_, d, &blocks);
  Add(gauge, nullptr, blocks);
  for (RotationBlock& block : at_.drives[d].rotations) {
    problem_->AddResidualBlock(new KnotCost(4), nullptr, block.data());
    SetManifold(problem_.get(), block.data(), &rotation_);
  }
  for (PositionBlock& block : at_.drives[d].positions) {
    problem_->AddResidualBlock(new KnotCost(3), nullptr, block.data());
  }
}

ceres::Solver::Summary CeresJointProblem::Solve(const SolveOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = options.linear_solver;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  solver.num_threads = options.threads;
  solver.max_num_iterations = options.iterations;
  // Gauss-Newton until a step is not worth taking, as the own solver: Marquardt's damping starts next to
  // nothing. Steps end where rounding does.
  solver.initial_trust_region_radius = solver.max_trust_region_radius = 1e16;
  solver.function_tolerance = 1e-13;
  solver.gradient_tolerance = 0.0;
  solver.parameter_tolerance = 0.0;
  solver.logging_type = ceres::SILENT;
  if (options.linear_solver == ceres::SPARSE_SCHUR) {
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    std::vector<double*> blocks;
    problem_->GetParameterBlocks(&blocks);
    for (double* block : blocks) ordering->AddElementToGroup(block, 1);
    for (EvaluationPoint::DriveBlocks& drive : at_.drives) {
      for (PlaneBlock& plane : drive.planes) ordering->AddElementToGroup(plane.data(), 0);
      for (PointBlock& point : drive.points) ordering->AddElementToGroup(point.data(), 0);
    }
    solver.linear_solver_ordering = std::move(ordering);
  }
  if (options.after_iteration != nullptr) {
    solver.update_state_every_iteration = true;
    solver.callbacks.push_back(options.after_iteration);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(solver, problem_.get(), &summary);
  return summary;
}

const CalibrationState& CeresJointProblem::State() {
  at_.PrepareForEvaluation(false, true);  // the last evaluation may be of a rejected step
  return at_.state;
}

Eigen::MatrixXd CeresJointProblem::Covariance(int threads) {
  std::vector<const double*> blocks;
  std::vector<int> columns;  // in the calibration vector, of each column that Ceres returns
  for (const CalibrationBlock& block : calibration_) {
    if (problem_->IsParameterBlockConstant(block.data)) continue;
    blocks.push_back(block.data);
    for (int i = 0; i < block.tangent; ++i) {
      if (free_[block.column + i]) columns.push_back(block.column + i);
    }
  }
  ceres::Covariance::Options options;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.algorithm_type = ceres::SPARSE_QR;
  options.num_threads = threads;
  ceres::Covariance covariance(options);
  if (!covariance.Compute(blocks, problem_.get())) {
    throw std::runtime_error("Ceres finds the normal matrix of the joint problem singular");
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  RowMajor found(columns.size(), columns.size());
  covariance.GetCovarianceMatrixInTangentSpace(blocks, found.data());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(layout_.calibration, layout_.calibration);
  for (std::size_t a = 0; a < columns.size(); ++a) {
    for (std::size_t b = 0; b < columns.size(); ++b) all(columns[a], columns[b]) = found(a, b);
  }
  return all;
}

}  // namespace mlic::ceres_reference
