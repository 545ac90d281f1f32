#include "mlic_core/uncertainty/imu_matrices.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/solver/submatrix.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"
#include "mlic_core/uncertainty/marginal_equations.h"

namespace mlic {
namespace {

// Parameters (Layout, with the matrices).
struct Places {
  std::vector<int> matrices, others;

  explicit Places(const Layout& layout) {
    for (int i = 0; i < layout.calibration; ++i) {
      const bool of_matrices = i >= layout.matrices && i < layout.matrices + Layout::kOfMatrices;
      (of_matrices ? matrices : others).push_back(i);
    }
  }
};

// Of the twelve entries, all that moves beside them followed.
MarginalEquations MarginalOfMatrices(JointProblem problem, const CalibrationState& state,
                                     const CalibrationEquations& probe, double scale) {
  problem.estimate_imu_matrices = true;
  const Layout layout(state, true);
  Eigen::MatrixXd prior;
  Eigen::VectorXd prior_gradient;
  CalibrationPrior(problem, state, layout, &prior, &prior_gradient);
  const std::vector<bool> moves = FreeCalibration(problem, layout);
  const Eigen::VectorXd limits = CalibrationLimits(state, layout);
  const Places places(layout);
  std::vector<int> others;
  std::copy_if(places.others.begin(), places.others.end(), std::back_inserter(others),
               [&](int i) { return moves[i]; });
  return MarginalOf(places.matrices, others, probe.information / scale, probe.gradient / scale, prior,
                    probe.prior_gradient, limits);
}

}  // namespace

MatrixEvidence EvidenceOfMatrices(const JointProblem& problem, const CalibrationState& state,
                                  const CalibrationEquations& probe, double scale) {
  MatrixEvidence evidence;
  if (probe.information.size() == 0) return evidence;
  const MarginalEquations marginal = MarginalOfMatrices(problem, state, probe, scale);
  const SymmetricEigen<Eigen::Dynamic> eigen(0.5 * (marginal.information + marginal.information.transpose()));
  const Eigen::VectorXd information = eigen.eigenvalues().cwiseMax(0.0);
  const Eigen::VectorXd gradient = eigen.eigenvectors().transpose() * marginal.gradient;
  // Each direction's likelihood is that of a normal variable of variance 1 / information + sigma^2.
  const auto gain = [&](double sigma) {
    const Eigen::ArrayXd excess = 1.0 + sigma * sigma * information.array();
    return (gradient.array().square() * sigma * sigma / excess - excess.log()).sum();
  };
  constexpr double kFinest = 1e-5, kCoarsest = 0.05;  // from: guard, of 1e-3 and 0.02, what IMUs have
  constexpr double kStep = 1.1;                       // from: guard, the likelihood is flat there
  for (double sigma = kFinest; sigma < kCoarsest; sigma *= kStep) {
    if (gain(sigma) > evidence.gain) evidence = {sigma, gain(sigma)};
  }
  return evidence;
}

Eigen::MatrixXd ScatterOfMatrices(const JointProblem& problem, const CalibrationState& state,
                                  const CalibrationEquations& probe, double scale) {
  constexpr double kDoubtful = 4.0;  // of the gain; from: derivation, two sigmas
  const int size = Layout(state, problem.estimate_imu_matrices).calibration;
  const MatrixEvidence evidence = EvidenceOfMatrices(problem, state, probe, scale);
  if (evidence.gain <= kDoubtful) return Eigen::MatrixXd::Zero(size, size);
  const Places places(Layout(state, true));
  const Eigen::MatrixXd cross = Submatrix(probe.information, places.others, places.matrices);
  return evidence.sigma * evidence.sigma / scale * cross * cross.transpose();
}

}  // namespace mlic
