#include "mlic_core/calibration/normal_equations.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"

extern "C" {
void dpotrf_(const char*, const int*, double*, const int*, int*);
void dpbtrf_(const char*, const int*, const int*, double*, const int*, int*);
void dpbtrs_(const char*, const int*, const int*, const int*, const double*, const int*, double*, const int*,
             int*);
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

// S -= sum over landmarks of W own^-1 W^T, gradient -= W own^-1 g; lower triangle, rows: control points,
// calibration. Landmarks that are seen at similar times are taken together, so that a batch touches few of
// the control points; their rows are gathered, multiplied densely, and scattered.
void EliminateLandmarks(const std::vector<LandmarkTies>& landmarks, int knots, bool hold_knots,
                        Eigen::MatrixXd* S, Eigen::VectorXd* gradient) {
  const int calibration = static_cast<int>(S->rows()) - (hold_knots ? 0 : knots);
  std::vector<double> mean(landmarks.size(), 0.0);
  std::vector<std::size_t> order(landmarks.size());
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    order[i] = i;
    for (const int column : landmarks[i].columns) mean[i] += column;
    if (!landmarks[i].columns.empty()) mean[i] /= static_cast<double>(landmarks[i].columns.size());
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return mean[a] < mean[b]; });
  std::vector<int> row_of(knots / 3);
  for (std::size_t begin = 0; begin < order.size(); begin += kBatch) {
    const std::size_t end = std::min(order.size(), begin + kBatch);
    std::fill(row_of.begin(), row_of.end(), -1);
    for (std::size_t k = begin; k < end && !hold_knots; ++k) {
      for (const int column : landmarks[order[k]].columns) row_of[column / 3] = 0;
    }
    std::vector<int> columns;
    for (int i = 0; i < knots / 3; ++i) {
      if (row_of[i] < 0) continue;
      row_of[i] = 3 * static_cast<int>(columns.size());
      columns.push_back(3 * i);
    }
    const int touched = 3 * static_cast<int>(columns.size());
    Eigen::MatrixXd D = Eigen::MatrixXd::Zero(touched + calibration, 3 * (end - begin));
    Eigen::VectorXd step(3 * (end - begin));
    ParallelFor(end - begin, [&](std::size_t k) {
      const LandmarkTies& landmark = landmarks[order[begin + k]];
      const Eigen::Matrix3d root = InverseRoot(landmark.own);
      const int at = static_cast<int>(3 * k);
      for (std::size_t b = 0; b < landmark.columns.size() && !hold_knots; ++b) {
        D.block<3, 3>(row_of[landmark.columns[b] / 3], at).noalias() = landmark.blocks[b] * root.transpose();
      }
      D.block(touched, at, calibration, 3).noalias() = landmark.calibration * root.transpose();
      step.segment<3>(at).noalias() = root * landmark.gradient;
    });
    const int n = touched + calibration, k = static_cast<int>(D.cols());
    Eigen::MatrixXd product(n, n);
    const double one = 1.0, zero = 0.0;
    dsyrk_("L", "N", &n, &k, &one, D.data(), &n, &zero, product.data(), &n);
    const Eigen::VectorXd moved = D * step;
    const int corner = hold_knots ? 0 : knots;
    ParallelFor(columns.size(), [&](std::size_t j) {
      for (int c = 0; c < 3; ++c) {
        const double* from = &product(0, 3 * j + c);
        double* to = &(*S)(0, columns[j] + c);
        for (std::size_t i = j; i < columns.size(); ++i) {
          for (int r = i == j ? c : 0; r < 3; ++r) to[columns[i] + r] -= from[3 * i + r];
        }
        for (int r = 0; r < calibration; ++r) to[corner + r] -= from[touched + r];
      }
    });
    for (std::size_t j = 0; j < columns.size(); ++j)
      gradient->segment<3>(columns[j]) -= moved.segment<3>(3 * j);
    S->bottomRightCorner(calibration, calibration).triangularView<Eigen::Lower>() -=
        product.bottomRightCorner(calibration, calibration);
    gradient->tail(calibration) -= moved.tail(calibration);
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
                                    const std::vector<bool>& free_calibration, double damping,
                                    bool hold_knots) {
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
  const Eigen::VectorXd moved = SolveCalibration(solution.information, corner_gradient, prior, prior_gradient,
                                                 free_calibration, damping);
  solution.delta.head(knots) = -right.rightCols<1>() - inverse_border * moved;
  solution.delta.tail(calibration) = moved;
  solution.solved = solution.delta.allFinite();
  return solution;
}

}  // namespace mlic
