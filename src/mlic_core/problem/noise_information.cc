#include "mlic_core/problem/noise_information.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/solver/normal_equations.h"

namespace mlic {
namespace {

// The information at the trajectory moved by `step`, the landmarks by theirs.
std::optional<Eigen::MatrixXd> InformationAt(const LinearizedProblem& linearized, const Eigen::VectorXd& step,
                                             const std::vector<Eigen::Vector3d>& landmark_steps) {
  CalibrationState moved = linearized.state;
  linearized.layout.Update(step, &moved);
  JointProblem followed = linearized.problem;
  MoveLandmarks(landmark_steps, &followed);
  std::vector<LandmarkCoupling> couplings;
  const Accumulator sum = Linearize({followed, moved, linearized.layout}, &couplings);
  const std::optional<ReducedEquations> equations = Reduce(sum, couplings);
  if (!equations) return std::nullopt;
  return equations->information;
}

Eigen::MatrixXd PositivePart(const Eigen::MatrixXd& matrix) {
  const SymmetricEigen<Eigen::Dynamic> eigen(0.5 * (matrix + matrix.transpose()));
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace

Eigen::MatrixXd NoiseInformation(const LinearizedProblem& linearized, const CancellationToken& cancellation) {
  const Layout& layout = linearized.layout;
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
  if (!linearized.solved) return none;
  const NoiseDraw& draw = linearized.draw;
  // There and back, so that what grows by the first order cancels.
  cancellation.ThrowIfCancelled();
  const std::optional<Eigen::MatrixXd> there = InformationAt(linearized, draw.step, draw.landmarks);
  cancellation.ThrowIfCancelled();
  const std::optional<Eigen::MatrixXd> opposite =
      InformationAt(linearized, -draw.step, draw.landmarks_of_opposite);
  if (!there || !opposite) return none;
  return 0.5 * (*there + *opposite) - linearized.information;
}

FreedOfNoise WithoutNoise(const Eigen::MatrixXd& information, const Eigen::MatrixXd& noise,
                          const Eigen::VectorXd& limits) {
  const auto in_limits = [&](const Eigen::MatrixXd& matrix) -> Eigen::MatrixXd {
    return limits.asDiagonal() * matrix * limits.asDiagonal();
  };
  const Eigen::MatrixXd S = in_limits(0.5 * (information + information.transpose()));
  const SymmetricEigen<Eigen::Dynamic> eigen(S);
  const double least = std::max(1e-12, 1e-15 * eigen.eigenvalues().maxCoeff());
  const Eigen::VectorXd root = eigen.eigenvalues().cwiseMax(least).cwiseSqrt();
  const Eigen::MatrixXd whiten = eigen.eigenvectors() * root.cwiseInverse().asDiagonal();
  const SymmetricEigen<Eigen::Dynamic> shares(whiten.transpose() * PositivePart(in_limits(noise)) * whiten);
  const Eigen::VectorXd left =
      shares.eigenvalues().unaryExpr([](double share) { return std::clamp(1.0 - share, 0.0, 1.0); });
  const Eigen::MatrixXd back =
      limits.cwiseInverse().asDiagonal() * eigen.eigenvectors() * root.asDiagonal() * shares.eigenvectors();
  const Eigen::MatrixXd forth = limits.asDiagonal() * whiten * shares.eigenvectors();
  return {back * left.cwiseAbs2().asDiagonal() * back.transpose(),
          back * left.asDiagonal() * forth.transpose()};
}

}  // namespace mlic
