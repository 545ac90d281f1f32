#include "mlic_core/uncertainty/imu_matrices.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "mlic_core/common/sizes_of_draws.h"
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

// The same along the eigenvectors of their information.
struct EntriesApart {
  Eigen::MatrixXd directions;  // a column each
  Eigen::ArrayXd information, gradient;

  explicit EntriesApart(const MarginalEquations& marginal) {
    const SymmetricEigen<Eigen::Dynamic> eigen(0.5 *
                                               (marginal.information + marginal.information.transpose()));
    directions = eigen.eigenvectors();
    information = eigen.eigenvalues().cwiseMax(0.0);
    gradient = directions.transpose() * marginal.gradient;
  }

  // Twice the logarithm of the likelihood's ratio to none, of draws with a sigma: along each direction the
  // gradient's is that of a normal variable of variance 1 / information + sigma^2.
  double Gain(double sigma) const {
    const Eigen::ArrayXd excess = 1.0 + sigma * sigma * information;
    return (gradient.square() * sigma * sigma / excess - excess.log()).sum();
  }

  // Of such draws, given the data: the mean of the entries' products.
  Eigen::MatrixXd MeanSquare(double sigma) const {
    const Eigen::ArrayXd variance = (information + 1.0 / (sigma * sigma)).inverse();
    const Eigen::VectorXd mean = directions * (-variance * gradient).matrix();
    return directions * variance.matrix().asDiagonal() * directions.transpose() + mean * mean.transpose();
  }
};

constexpr double kStep = 1.1;  // of sigmas from one to the next; from: guard, the likelihood is flat there

}  // namespace

MatrixEvidence EvidenceOfMatrices(const JointProblem& problem, const CalibrationState& state,
                                  const CalibrationEquations& probe, double scale) {
  MatrixEvidence evidence;
  if (probe.information.size() == 0) return evidence;
  const EntriesApart entries(MarginalOfMatrices(problem, state, probe, scale));
  constexpr double kFinest = 1e-5, kCoarsest = 0.05;  // from: guard, of 1e-3 and 0.02, what IMUs have
  for (const double sigma : SizesBetween(kFinest, kCoarsest, kStep)) {
    if (entries.Gain(sigma) > evidence.gain) evidence = {sigma, entries.Gain(sigma)};
  }
  return evidence;
}

Eigen::MatrixXd ScatterOfMatrices(const JointProblem& problem, const CalibrationState& state,
                                  const CalibrationEquations& probe, double scale) {
  const int size = Layout(state, problem.estimate_imu_matrices).calibration;
  if (problem.estimate_imu_matrices || probe.information.size() == 0)
    return Eigen::MatrixXd::Zero(size, size);
  const EntriesApart entries(MarginalOfMatrices(problem, state, probe, scale));
  // from: standard, data sheets of IMUs, from tactical to consumer grade
  constexpr double kFinest = 1e-4, kCoarsest = 0.02;
  const Eigen::MatrixXd square = MeanSquareOfSizes(entries, SizesBetween(kFinest, kCoarsest, kStep));
  const Places places(Layout(state, true));
  const Eigen::MatrixXd cross = Submatrix(probe.information, places.others, places.matrices);
  return cross * square * cross.transpose() / scale;
}

}  // namespace mlic
