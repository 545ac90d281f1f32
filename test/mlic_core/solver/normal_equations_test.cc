#include "mlic_core/solver/normal_equations.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "mlic_core/common/random.h"
#include "mlic_core/problem/linear_terms.h"
#include "mlic_core/solver/envelope_cholesky.h"

namespace mlic::normal_equations_test {
namespace {

Eigen::MatrixXd RandomMatrix(int rows, int columns, Random* random) {
  Eigen::MatrixXd matrix(rows, columns);
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < rows; ++i) matrix(i, j) = random->Normal();
  }
  return matrix;
}

TEST(EnvelopeMatrix, FactorsAsADenseOneDoes) {
  constexpr int kSize = 500, kBorder = 7;
  Random random(1);
  std::vector<int> reach(kSize);
  Eigen::MatrixXd A = 60.0 * Eigen::MatrixXd::Identity(kSize, kSize);
  for (int j = 0; j < kSize; ++j) {
    reach[j] = std::min(kSize - 1, j + (j < 200 ? 5 : j % 130));
    for (int i = j + 1; i <= reach[j]; ++i) A(i, j) = A(j, i) = random.Normal();
  }
  const Eigen::MatrixXd border = RandomMatrix(kBorder, kSize, &random);
  EnvelopeMatrix envelope(reach, kBorder);
  for (int j = 0; j < kSize; ++j) {
    for (int i = j; i <= reach[j]; ++i) envelope.Column(j)[i - EnvelopeMatrix::FirstRow(j)] = A(i, j);
  }
  envelope.border = border;
  ASSERT_TRUE(envelope.Factor());
  const Eigen::MatrixXd schur = border * A.llt().solve(border.transpose());
  EXPECT_LT((envelope.border * envelope.border.transpose() - schur).norm(), 1e-12 * schur.norm());
  Eigen::VectorXd x = envelope.border.row(0).transpose();
  envelope.SolveTransposed(&x);
  EXPECT_LT((A * x - border.row(0).transpose()).norm(), 1e-11);
  Eigen::MatrixXd rows = envelope.border.colwise().reverse().replicate(9, 1);
  const Eigen::MatrixXd right = border.colwise().reverse().replicate(9, 1);
  envelope.SolveTransposedRows(&rows);
  EXPECT_LT((rows * A - right).norm(), 1e-10);
}

TEST(EnvelopeMatrix, SaysWhenItIsNotPositiveDefinite) {
  EnvelopeMatrix envelope(std::vector<int>(150, 0), 0);
  for (int j = 0; j < 150; ++j) envelope.Column(j)[j - EnvelopeMatrix::FirstRow(j)] = j == 120 ? -1.0 : 1.0;
  EXPECT_FALSE(envelope.Factor());
}

// Random normal equations with `landmarks` landmarks, each seen over `span` control points, in the form that
// the solver takes and dense (control points, calibration, landmarks).
struct Equations {
  static constexpr int kCalibration = 9;

  Equations(int control_points, int landmarks, int span, std::uint64_t seed)
      : knots(3 * control_points), sum(knots, kBandwidth, kCalibration), couplings(landmarks) {
    Random random(seed);
    CouplingSlots slots(knots);
    const int total = knots + kCalibration + 3 * landmarks;
    H = Eigen::MatrixXd::Zero(total, total);
    g = Eigen::VectorXd::Zero(total);
    for (int k = 0; k + 4 <= control_points; ++k) {
      Add(RandomMatrix(12, 14, &random), RandomMatrix(kCalibration, 14, &random), 3 * k, -1, {}, &slots,
          &random);
    }
    for (int p = 0; p < landmarks; ++p) {
      const int first = span < control_points - 4 ? (p * 7) % (control_points - span - 4) : 0;
      couplings[p].calibration = Eigen::MatrixXd::Zero(kCalibration, 3);
      for (int k = first; k < first + std::min(span, control_points - 4); k += 3) {
        Add(RandomMatrix(12, 2, &random), RandomMatrix(kCalibration, 2, &random), 3 * k, p,
            RandomMatrix(3, 2, &random), &slots, &random);
      }
      slots.Finish(&couplings[p]);
    }
    H = H.selfadjointView<Eigen::Lower>();
  }

  // Adds J J^T of residuals that touch 4 control points, the calibration and perhaps a landmark.
  void Add(const Eigen::MatrixXd& of_knots, const Eigen::MatrixXd& of_calibration, int column, int landmark,
           const Eigen::MatrixXd& of_landmark, CouplingSlots* slots, Random* random) {
    const Eigen::VectorXd r = RandomMatrix(static_cast<int>(of_knots.cols()), 1, random);
    for (int a = 0; a < 4; ++a) {
      const auto J = of_knots.middleRows<3>(3 * a);
      sum.gradient_knots.segment<3>(column + 3 * a) += J * r;
      sum.border.middleCols<3>(column + 3 * a) += of_calibration * J.transpose();
      for (int b = 0; b <= a; ++b) {
        sum.AddBand(column + 3 * a, column + 3 * b, J * of_knots.middleRows<3>(3 * b).transpose());
      }
      if (landmark >= 0) slots->Block(column + 3 * a) += J * of_landmark.transpose();
    }
    sum.corner += of_calibration * of_calibration.transpose();
    sum.gradient_calibration += of_calibration * r;
    if (landmark >= 0) {
      couplings[landmark].own += of_landmark * of_landmark.transpose();
      couplings[landmark].gradient += of_landmark * r;
      couplings[landmark].calibration += of_calibration * of_landmark.transpose();
    }
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(H.rows(), of_knots.cols());
    rows.middleRows(column, 12) = of_knots;
    rows.middleRows(knots, kCalibration) = of_calibration;
    if (landmark >= 0) rows.middleRows<3>(knots + kCalibration + 3 * landmark) = of_landmark;
    H.selfadjointView<Eigen::Lower>().rankUpdate(rows);
    g += rows * r;
  }

  static constexpr int kBandwidth = 11;
  int knots;
  Accumulator sum;
  std::vector<LandmarkCoupling> couplings;
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
};

NormalSolution Solve(const Equations& e, const std::vector<bool>& free, double damping, bool hold_knots) {
  return SolveNormalEquations(e.sum, e.couplings, Eigen::MatrixXd::Zero(9, 9), Eigen::VectorXd::Zero(9), free,
                              damping, hold_knots);
}

void ExpectDenseSolution(const Equations& e) {
  const std::vector<bool> free(9, true);
  const NormalSolution solution = Solve(e, free, 0.0, false);
  ASSERT_TRUE(solution.solved);
  const Eigen::VectorXd delta = -e.H.llt().solve(e.g);
  EXPECT_LT((solution.delta - delta.head(solution.delta.size())).norm(), 1e-7 * delta.norm());
  const Eigen::MatrixXd covariance = e.H.llt().solve(Eigen::MatrixXd::Identity(e.H.rows(), e.H.rows()));
  const Eigen::MatrixXd information = covariance.block(e.knots, e.knots, 9, 9).inverse();
  EXPECT_LT((solution.information - information).norm(), 1e-7 * information.norm());
}

TEST(NormalEquations, AgreeWithDenseOnesWhenLandmarksAreSeenForAWhile) {
  ExpectDenseSolution(Equations(200, 170, 30, 2));
}
TEST(NormalEquations, AgreeWithDenseOnesWhenLandmarksAreSeenThroughout) {
  ExpectDenseSolution(Equations(90, 40, 90, 3));
}
TEST(NormalEquations, AgreeWithDenseOnesWithoutLandmarks) { ExpectDenseSolution(Equations(100, 0, 0, 4)); }

TEST(NormalEquations, HoldWhatIsHeld) {
  const Equations e(60, 30, 20, 5);
  std::vector<bool> free(9, true);
  free[2] = free[7] = false;
  const NormalSolution solution = Solve(e, free, 0.0, false);
  EXPECT_EQ(solution.delta[e.knots + 2], 0.0);
  EXPECT_EQ(solution.delta[e.knots + 7], 0.0);
  // The rest is what one gets without those rows and columns.
  std::vector<int> kept;
  for (int i = 0; i < e.H.rows(); ++i) {
    if (i != e.knots + 2 && i != e.knots + 7) kept.push_back(i);
  }
  Eigen::MatrixXd H(kept.size(), kept.size());
  Eigen::VectorXd g(kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    g[i] = e.g[kept[i]];
    for (std::size_t j = 0; j < kept.size(); ++j) H(i, j) = e.H(kept[i], kept[j]);
  }
  const Eigen::VectorXd delta = -H.llt().solve(g);
  for (int i = 0; i < e.knots + 7; ++i) EXPECT_NEAR(solution.delta[kept[i]], delta[i], 1e-8 * delta.norm());
}

TEST(NormalEquations, HeldControlPointsStayAndLeaveOnlyTheCalibration) {
  const Equations e(60, 50, 20, 6);
  const NormalSolution solution = Solve(e, std::vector<bool>(9, true), 0.0, true);
  EXPECT_EQ(solution.delta.head(e.knots).norm(), 0.0);
  const int rest = static_cast<int>(e.H.rows()) - e.knots;
  const Eigen::VectorXd delta = -e.H.bottomRightCorner(rest, rest).llt().solve(e.g.tail(rest));
  EXPECT_LT((solution.delta.tail(9) - delta.head(9)).norm(), 1e-8 * delta.norm());
}

TEST(NormalEquations, DampingFallsFasterWhereStepsDoAsToldAndEnds) {
  EXPECT_DOUBLE_EQ(DampingAfter(1e-4, 1.1), 1e-6);
  EXPECT_DOUBLE_EQ(DampingAfter(1e-4, 0.5), 1e-5);
  EXPECT_DOUBLE_EQ(DampingAfter(1e-4, 3.0), 1e-5) << "points that settle lower the cost by more";
  EXPECT_DOUBLE_EQ(DampingAfter(1e-6, 1.0), 1e-8) << "weak directions move with hardly any";
  EXPECT_EQ(DampingAfter(5e-9, 0.1), 0.0);
}

TEST(NormalEquations, DampingShortensTheStep) {
  const Equations e(60, 50, 20, 7);
  const std::vector<bool> free(9, true);
  EXPECT_LT(Solve(e, free, 1.0, false).delta.norm(), 0.9 * Solve(e, free, 0.0, false).delta.norm());
}

}  // namespace
}  // namespace mlic::normal_equations_test
