#include "ceres_reference/calibration_blocks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/priors.h"

namespace mlic::ceres_reference {
namespace {

void AddSensor(SensorCalibration* sensor, int column, std::vector<CalibrationBlock>* blocks) {
  blocks->push_back({sensor->T_imu_sensor.rotation.coeffs().data(), 4, 3, column, PlusLeft});
  blocks->push_back({sensor->T_imu_sensor.translation.data(), 3, 3, column + 3, nullptr});
  blocks->push_back({&sensor->time_offset, 1, 1, column + 6, nullptr});
}

}  // namespace

std::vector<CalibrationBlock> CalibrationBlocks(EvaluationPoint* at, const Layout& layout) {
  std::vector<CalibrationBlock> blocks;
  CalibrationState& state = at->state;
  for (std::size_t i = 0; i < state.lidars.size(); ++i)
    AddSensor(&state.lidars[i], Layout::Lidar(i), &blocks);
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    AddSensor(&state.cameras[c].sensor, layout.Camera(c), &blocks);
  }
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    CameraCalibration& camera = state.cameras[c];
    std::vector<double>& intrinsics = camera.intrinsics.parameters;
    const int count = static_cast<int>(intrinsics.size());
    if (layout.Readout(c) >= 0) blocks.push_back({&camera.readout, 1, 1, layout.Readout(c), nullptr});
    blocks.push_back({intrinsics.data(), count, count, layout.Intrinsics(c), nullptr});
  }
  blocks.push_back({&state.gravity, 1, 1, layout.gravity, nullptr});
  blocks.push_back({&state.accelerometer_lag, 1, 1, layout.lag, nullptr});
  if (layout.matrices < 0) {
    blocks.push_back({state.accelerometer_matrix.data(), 9, 3, layout.alignment, PlusAlignment});
  } else {
    blocks.push_back({state.accelerometer_matrix.data(), 9, 9, layout.alignment, PlusAccelerometer});
    blocks.push_back({state.gyroscope_matrix.data(), 9, 6, layout.matrices + 6, PlusGyroscope});
  }
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    double* bias = state.drives[d].bias.knots[0].data();  // constant
    blocks.push_back({bias, Layout::kOfBias, Layout::kOfBias, layout.Bias(d, 0), nullptr});
  }
  return blocks;
}

std::vector<std::unique_ptr<CeresManifold>> SetCalibrationManifolds(
    const std::vector<CalibrationBlock>& blocks, const std::vector<bool>& free, ceres::Problem* problem) {
  std::vector<std::unique_ptr<CeresManifold>> manifolds;
  const auto set = [&](double* data, std::unique_ptr<CeresManifold> manifold) {
    SetManifold(problem, data, manifold.get());
    manifolds.push_back(std::move(manifold));
  };
  for (const CalibrationBlock& block : blocks) {
    std::vector<int> fixed;
    for (int i = 0; i < block.tangent; ++i) {
      if (!free[block.column + i]) fixed.push_back(i);
    }
    if (static_cast<int>(fixed.size()) == block.tangent) {
      problem->SetParameterBlockConstant(block.data);
    } else if (block.plus != nullptr) {
      Check(fixed.empty(), "Ceres reference: a rotation or matrix is fixed in part");
      set(block.data, std::make_unique<LiftedManifold>(block.ambient, block.tangent, block.plus));
    } else if (!fixed.empty()) {
      set(block.data, std::make_unique<CeresSubsetManifold>(block.ambient, fixed));
    }
  }
  return manifolds;
}

PriorCost::PriorCost(const JointProblem& problem, EvaluationPoint* at, const Layout& layout, BlockList* list)
    : problem_(problem), at_(*at), layout_(layout), blocks_(CalibrationBlocks(at, layout)) {
  for (const CalibrationBlock& block : blocks_) list->Add(block.data, block.ambient);
  *mutable_parameter_block_sizes() = list->ambients;
  set_num_residuals(layout.calibration);
}

bool PriorCost::Evaluate(double const* const*, double* residuals, double** jacobians) const {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  CalibrationPrior(problem_, at_.state, layout_, &information, &gradient);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  const double least = 1e-12 * eigen.eigenvalues().maxCoeff();  // rounding
  const Eigen::VectorXd root = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse =
      (eigen.eigenvalues().array() > least).select(root.cwiseMax(std::sqrt(least)).cwiseInverse(), 0.0);
  Eigen::Map<Eigen::VectorXd>(residuals, gradient.size()) =
      inverse.asDiagonal() * eigen.eigenvectors().transpose() * gradient;
  if (jacobians == nullptr) return true;
  const Eigen::MatrixXd rows = eigen.eigenvectors() * root.asDiagonal();
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    WriteBlock(rows, blocks_[b].column, blocks_[b].tangent, blocks_[b].ambient, jacobians[b]);
  }
  return true;
}

}  // namespace mlic::ceres_reference
