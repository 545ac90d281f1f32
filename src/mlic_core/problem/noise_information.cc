#include "mlic_core/problem/noise_information.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/solver/normal_equations.h"

namespace mlic {
namespace {

// rad and m: control points at the ends of a drive that next to nothing shows stay where they are.
constexpr double kShownControlPoint = 0.3;  // from: guard

// The information at the trajectory moved by `step`; landmarks follow it.
std::optional<Eigen::MatrixXd> InformationAt(const JointProblem& problem, const CalibrationState& state,
                                             const std::vector<LandmarkCoupling>& couplings,
                                             const Eigen::VectorXd& step) {
  const Layout layout(state, problem.estimate_imu_matrices);
  CalibrationState moved = state;
  layout.Update(step, &moved);
  JointProblem followed = problem;
  MoveLandmarks(couplings, step, &followed);
  std::vector<LandmarkCoupling> at_moved;
  const Accumulator sum = Linearize({followed, moved, layout}, &at_moved);
  return CalibrationInformation(sum, at_moved);
}

Eigen::MatrixXd PositivePart(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (matrix + matrix.transpose()));
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace

Eigen::MatrixXd NoiseInformation(const JointProblem& given, const CalibrationState& state,
                                 const CancellationToken& cancellation) {
  const Layout layout(state, given.estimate_imu_matrices);
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
  if (given.fix_trajectory) return none;
  std::vector<std::vector<std::size_t>> origins;
  const JointProblem problem = WithShortCouplings(given, state, &origins);
  std::vector<LandmarkCoupling> couplings;
  const Accumulator sum = Linearize({problem, state, layout}, &couplings);
  const std::optional<KnotsByNoise> knots = DrawKnots(sum, couplings);
  if (!knots) return none;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(layout.Total());
  step.head(layout.knots) =
      knots->deviation.unaryExpr([](double v) { return std::abs(v) < kShownControlPoint ? v : 0.0; });
  // There and back, so that what grows by the first order cancels.
  Eigen::MatrixXd excess = -knots->information;
  for (const double side : {1.0, -1.0}) {
    cancellation.ThrowIfCancelled();
    const std::optional<Eigen::MatrixXd> there = InformationAt(problem, state, couplings, side * step);
    if (!there) return none;
    excess += 0.5 * *there;
  }
  return excess;
}

Eigen::MatrixXd WithoutNoise(const Eigen::MatrixXd& information, const Eigen::MatrixXd& noise,
                             const Eigen::VectorXd& limits) {
  const auto in_limits = [&](const Eigen::MatrixXd& matrix) -> Eigen::MatrixXd {
    return limits.asDiagonal() * matrix * limits.asDiagonal();
  };
  const Eigen::MatrixXd S = in_limits(0.5 * (information + information.transpose()));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(S);
  const double least = std::max(1e-12, 1e-15 * eigen.eigenvalues().maxCoeff());
  const Eigen::VectorXd root = eigen.eigenvalues().cwiseMax(least).cwiseSqrt();
  const Eigen::MatrixXd whiten = eigen.eigenvectors() * root.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> shares(whiten.transpose() *
                                                              PositivePart(in_limits(noise)) * whiten);
  const Eigen::VectorXd left =
      shares.eigenvalues().unaryExpr([](double share) { return std::clamp(1.0 - share, 0.0, 1.0); });
  const Eigen::MatrixXd back =
      limits.cwiseInverse().asDiagonal() * eigen.eigenvectors() * root.asDiagonal() * shares.eigenvectors();
  return back * left.cwiseAbs2().asDiagonal() * back.transpose();
}

}  // namespace mlic
