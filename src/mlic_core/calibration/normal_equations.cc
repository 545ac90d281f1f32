#include "mlic_core/calibration/normal_equations.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "mlic_core/common/error.h"

extern "C" {
void dpotrf_(const char*, const int*, double*, const int*, int*);
void dpbtrf_(const char*, const int*, const int*, double*, const int*, int*);
void dpbtrs_(const char*, const int*, const int*, const int*, const double*, const int*, double*, const int*, int*);
void dpotrs_(const char*, const int*, const int*, const double*, const int*, double*, const int*, int*);
void dsyrk_(const char*, const char*, const int*, const int*, const double*, const double*, const int*,
            const double*, double*, const int*);
}

namespace mlic {
namespace {

// Landmarks handled in one rank update; wide enough that the matrix is not streamed too often.
constexpr std::size_t kBatch = 128;

Eigen::Matrix3d InverseRoot(const Eigen::Matrix3d& own) {
  Eigen::Matrix3d damped = own;
  damped.diagonal() *= 1.0 + 1e-12;
  damped.diagonal().array() += 1e-9;
  const Eigen::LLT<Eigen::Matrix3d> llt(damped);
  return llt.matrixL().solve(Eigen::Matrix3d::Identity());  // L^-1
}

// S -= sum over landmarks of W own^-1 W^T, gradient -= W own^-1 g; lower triangle, rows: control points, calibration.
void EliminateLandmarks(const std::vector<LandmarkTies>& landmarks, int knots, bool hold_knots, Eigen::MatrixXd* S,
                        Eigen::VectorXd* gradient) {
  const int total = static_cast<int>(S->rows());
  const int calibration_row = hold_knots ? 0 : knots;
  // In order of their first control point, so that a batch touches a part of the matrix only.
  std::vector<std::size_t> order(landmarks.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto first_column = [&](std::size_t i) {
    const auto& columns = landmarks[i].columns;
    return columns.empty() ? 0 : *std::min_element(columns.begin(), columns.end());
  };
  std::vector<int> first(landmarks.size());
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = first_column(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return first[a] < first[b]; });
  for (std::size_t begin = 0; begin < order.size(); begin += kBatch) {
    const std::size_t end = std::min(order.size(), begin + kBatch);
    const int low = hold_knots ? 0 : first[order[begin]];
    Eigen::MatrixXd D = Eigen::MatrixXd::Zero(total - low, 3 * (end - begin));
    for (std::size_t k = begin; k < end; ++k) {
      const LandmarkTies& landmark = landmarks[order[k]];
      const Eigen::Matrix3d root = InverseRoot(landmark.own);
      const int column = static_cast<int>(3 * (k - begin));
      if (!hold_knots) {
        for (std::size_t b = 0; b < landmark.columns.size(); ++b) {
          D.block<3, 3>(landmark.columns[b] - low, column).noalias() = landmark.blocks[b] * root.transpose();
        }
      }
      D.block(calibration_row - low, column, landmark.calibration.rows(), 3).noalias() =
          landmark.calibration * root.transpose();
      gradient->segment(low, total - low).noalias() -=
          D.middleCols<3>(column) * (root * landmark.gradient);
    }
    const int n = total - low, k = static_cast<int>(D.cols());
    const double minus = -1.0, plus = 1.0;
    dsyrk_("L", "N", &n, &k, &minus, D.data(), &n, &plus, &(*S)(low, low), &total);
  }
}

// Solves in the calibration alone, given its information (Schur complement) and gradient.
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
  return -H.ldlt().solve(g);
}

NormalSolution SolveBanded(const Accumulator& sum, const Eigen::MatrixXd& prior,
                           const Eigen::VectorXd& prior_gradient, const std::vector<bool>& free_calibration,
                           double damping) {
  NormalSolution solution;
  Eigen::MatrixXd band = sum.band;
  band.row(0) *= 1.0 + damping;
  const int n = static_cast<int>(band.cols()), width = static_cast<int>(band.rows()) - 1, ld = width + 1;
  int info = 0;
  dpbtrf_("L", &n, &width, band.data(), &ld, &info);
  if (info != 0) return solution;
  Eigen::MatrixXd right(n, sum.border.rows() + 1);
  right.leftCols(sum.border.rows()) = sum.border.transpose();
  right.rightCols<1>() = sum.gradient_knots;
  const int columns = static_cast<int>(right.cols());
  dpbtrs_("L", &n, &width, &columns, band.data(), &ld, right.data(), &n, &info);
  const auto inverse_border = right.leftCols(sum.border.rows());
  solution.information = sum.corner - sum.border * inverse_border;
  const Eigen::VectorXd gradient = sum.gradient_calibration - sum.border * right.rightCols<1>();
  const Eigen::VectorXd calibration =
      SolveCalibration(solution.information, gradient, prior, prior_gradient, free_calibration, damping);
  solution.delta.resize(n + calibration.size());
  solution.delta.head(n) = -right.rightCols<1>() - inverse_border * calibration;
  solution.delta.tail(calibration.size()) = calibration;
  solution.solved = solution.delta.allFinite();
  return solution;
}

}  // namespace

Accumulator::Accumulator(int knots, int bandwidth, int calibration)
    : band(Eigen::MatrixXd::Zero(bandwidth + 1, knots)),
      border(Eigen::MatrixXd::Zero(calibration, knots)),
      corner(Eigen::MatrixXd::Zero(calibration, calibration)),
      gradient_knots(Eigen::VectorXd::Zero(knots)),
      gradient_calibration(Eigen::VectorXd::Zero(calibration)) {}

Accumulator& Accumulator::operator+=(const Accumulator& other) {
  band += other.band;
  border += other.border;
  corner += other.corner;
  gradient_knots += other.gradient_knots;
  gradient_calibration += other.gradient_calibration;
  cost += other.cost;
  return *this;
}

NormalSolution SolveNormalEquations(const Accumulator& sum, const std::vector<LandmarkTies>& landmarks,
                                    const Eigen::MatrixXd& prior, const Eigen::VectorXd& prior_gradient,
                                    const std::vector<bool>& free_calibration, double damping, bool hold_knots) {
  const int calibration = static_cast<int>(sum.corner.rows());
  const int knots = static_cast<int>(sum.band.cols());
  if (landmarks.empty() && !hold_knots) {
    return SolveBanded(sum, prior, prior_gradient, free_calibration, damping);
  }
  const int free_knots = hold_knots ? 0 : knots;
  const int total = free_knots + calibration;
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(total, total);
  Eigen::VectorXd gradient(total);
  for (int j = 0; j < free_knots; ++j) {
    const int rows = std::min<int>(static_cast<int>(sum.band.rows()), knots - j);
    S.col(j).segment(j, rows) = sum.band.col(j).head(rows);
  }
  gradient.head(free_knots) = sum.gradient_knots.head(free_knots);
  if (!hold_knots) S.bottomLeftCorner(calibration, knots) = sum.border;
  S.bottomRightCorner(calibration, calibration) = sum.corner;
  gradient.tail(calibration) = sum.gradient_calibration;
  const Eigen::VectorXd diagonal = S.diagonal();
  EliminateLandmarks(landmarks, knots, hold_knots, &S, &gradient);

  NormalSolution solution;
  Eigen::MatrixXd corner = S.bottomRightCorner(calibration, calibration).selfadjointView<Eigen::Lower>();
  Eigen::VectorXd corner_gradient = gradient.tail(calibration);
  solution.delta = Eigen::VectorXd::Zero(knots + calibration);
  if (hold_knots) {
    solution.information = corner;
    solution.delta.tail(calibration) =
        SolveCalibration(corner, corner_gradient, prior, prior_gradient, free_calibration, damping);
    solution.solved = solution.delta.allFinite();
    return solution;
  }
  // Control points first; the calibration is what is left over, so its information comes out by the way.
  S.diagonal().head(knots) += damping * diagonal.head(knots);
  int info = 0;
  dpotrf_("L", &knots, S.data(), &total, &info);
  if (info != 0) return solution;
  Eigen::MatrixXd right(knots, calibration + 1);
  right.leftCols(calibration) = S.bottomLeftCorner(calibration, knots).transpose();
  right.rightCols<1>() = gradient.head(knots);
  const Eigen::MatrixXd border = S.bottomLeftCorner(calibration, knots);
  const int columns = calibration + 1;
  dpotrs_("L", &knots, &columns, S.data(), &total, right.data(), &knots, &info);
  const auto inverse_border = right.leftCols(calibration);
  solution.information = corner - border * inverse_border;
  solution.information = (0.5 * (solution.information + solution.information.transpose())).eval();
  corner_gradient -= border * right.rightCols<1>();
  const Eigen::VectorXd moved =
      SolveCalibration(solution.information, corner_gradient, prior, prior_gradient, free_calibration, damping);
  solution.delta.head(knots) = -right.rightCols<1>() - inverse_border * moved;
  solution.delta.tail(calibration) = moved;
  solution.solved = solution.delta.allFinite();
  return solution;
}

}  // namespace mlic
