#include "mlic_core/solver/normal_equations.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/solver/schur_complement.h"

namespace mlic {
namespace {

// The last row that each control point's column reaches, by the band and by the landmarks that tie it.
std::vector<int> Reach(const Accumulator& sum, const std::vector<LandmarkCoupling>& landmarks) {
  const int knots = static_cast<int>(sum.band.cols()), bandwidth = static_cast<int>(sum.band.rows()) - 1;
  std::vector<int> reach(knots);
  for (int j = 0; j < knots; ++j) reach[j] = std::min(knots - 1, j + bandwidth);
  for (const LandmarkCoupling& landmark : landmarks) {
    if (landmark.columns.empty()) continue;
    const auto range = std::minmax_element(landmark.columns.begin(), landmark.columns.end());
    reach[*range.first] = std::max(reach[*range.first], *range.second + 2);
  }
  return reach;
}

EnvelopeMatrix KnotMatrix(const Accumulator& sum, const std::vector<LandmarkCoupling>& landmarks) {
  EnvelopeMatrix A(Reach(sum, landmarks), static_cast<int>(sum.corner.rows()) + 1);
  for (int j = 0; j < A.size(); ++j) {
    const int rows = std::min<int>(static_cast<int>(sum.band.rows()), A.size() - j);
    Eigen::Map<Eigen::VectorXd>(A.Column(j) + j - EnvelopeMatrix::FirstRow(j), rows) =
        sum.band.col(j).head(rows);
  }
  A.border.topRows(sum.border.rows()) = sum.border;
  A.border.bottomRows<1>() = sum.gradient_knots.transpose();
  return A;
}

}  // namespace

Eigen::VectorXd SolveCalibration(const Eigen::MatrixXd& information, const Eigen::VectorXd& gradient,
                                 const Eigen::MatrixXd& prior, const Eigen::VectorXd& prior_gradient,
                                 const std::vector<bool>& free_calibration, double damping) {
  Eigen::MatrixXd H = information + prior;
  Eigen::VectorXd g = gradient + prior_gradient;
  for (int i = 0; i < H.rows(); ++i) {
    H(i, i) += damping * H(i, i) + 1e-9;
    if (free_calibration[i]) continue;
    H.row(i).setZero();
    H.col(i).setZero();
    H(i, i) = 1.0;
    g[i] = 0.0;
  }
  return -SolveSymmetric(H, g);
}

NormalSolution SolveNormalEquations(const Accumulator& sum, const std::vector<LandmarkCoupling>& landmarks,
                                    const Eigen::MatrixXd& prior, const Eigen::VectorXd& prior_gradient,
                                    const std::vector<bool>& free_calibration, double damping,
                                    bool hold_knots) {
  const int calibration = static_cast<int>(sum.corner.rows());
  const int knots = static_cast<int>(sum.band.cols());
  NormalSolution solution;
  solution.delta = Eigen::VectorXd::Zero(knots + calibration);
  // The calibration, and the gradient as one more row and column.
  Eigen::MatrixXd corner = Eigen::MatrixXd::Zero(calibration + 1, calibration + 1);
  corner.topLeftCorner(calibration, calibration) = sum.corner;
  corner.bottomLeftCorner(1, calibration) = sum.gradient_calibration.transpose();
  const auto solve_calibration = [&] {
    solution.information = corner.topLeftCorner(calibration, calibration).selfadjointView<Eigen::Lower>();
    solution.gradient = corner.bottomLeftCorner(1, calibration).transpose();
    solution.delta.tail(calibration) = SolveCalibration(solution.information, solution.gradient, prior,
                                                        prior_gradient, free_calibration, damping);
  };
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(knots + calibration);  // landmarks eliminated
  if (hold_knots) {
    EliminateLandmarksFromCorner(landmarks, &corner);
    gradient.tail(calibration) = corner.bottomLeftCorner(1, calibration).transpose();
    solve_calibration();
  } else {
    // Control points first; the calibration is what is left over, so its information comes out by the way.
    EnvelopeMatrix A = KnotMatrix(sum, landmarks);
    EliminateLandmarks(landmarks, &A, &corner);
    gradient.head(knots) = A.border.bottomRows<1>().transpose();
    gradient.tail(calibration) = corner.bottomLeftCorner(1, calibration).transpose();
    for (int j = 0; j < knots; ++j) {
      A.Column(j)[j - EnvelopeMatrix::FirstRow(j)] += damping * sum.band(0, j);
    }
    if (!A.Factor()) return solution;
    corner.triangularView<Eigen::Lower>() -= A.border * A.border.transpose();
    solve_calibration();
    Eigen::VectorXd right = -(A.border.topRows(calibration).transpose() * solution.delta.tail(calibration));
    right -= A.border.bottomRows<1>().transpose();
    A.SolveTransposed(&right);
    solution.delta.head(knots) = right;
  }
  solution.predicted_decrease = -gradient.dot(solution.delta);
  solution.solved = solution.delta.allFinite();
  return solution;
}

std::optional<ReducedEquations> Reduce(const Accumulator& sum,
                                       const std::vector<LandmarkCoupling>& landmarks) {
  const Eigen::Index calibration = sum.corner.rows();
  Eigen::MatrixXd corner = Eigen::MatrixXd::Zero(calibration + 1, calibration + 1);
  corner.topLeftCorner(calibration, calibration) = sum.corner;
  EnvelopeMatrix A = KnotMatrix(sum, landmarks);
  EliminateLandmarks(landmarks, &A, &corner);
  if (!A.Factor()) return std::nullopt;
  corner.triangularView<Eigen::Lower>() -= A.border * A.border.transpose();
  Eigen::MatrixXd information =
      corner.topLeftCorner(calibration, calibration).selfadjointView<Eigen::Lower>();
  return ReducedEquations{std::move(A), std::move(information)};
}

Eigen::VectorXd ReducedEquations::DrawKnots() const {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> draw;
  Eigen::VectorXd deviation(factor.size());
  for (double& value : deviation) value = draw(engine);
  factor.SolveTransposed(&deviation);
  return deviation;
}

Eigen::MatrixXd ReducedEquations::KnotResponse() const {
  Eigen::MatrixXd response = factor.border.topRows(information.rows());
  factor.SolveTransposedRows(&response);
  return response;
}

double DampingAfter(double damping, double gain) {
  constexpr double kLeast = 1e-9;  // from: guard, as singular as equations get
  constexpr double kWell = 0.25;   // from: guard, as usual for trust regions
  damping *= std::abs(gain - 1.0) < kWell ? 0.01 : 0.1;
  return damping < kLeast ? 0.0 : damping;
}

}  // namespace mlic
