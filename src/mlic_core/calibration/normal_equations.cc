#include "mlic_core/calibration/normal_equations.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "mlic_core/calibration/blas.h"
#include "mlic_core/calibration/envelope_cholesky.h"
#include "mlic_core/common/parallel.h"

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

// What the calibration and the gradient have to do with a landmark, by its inverse root: rows of the
// calibration, then one of the gradient.
void FillBorderRows(const LandmarkTies& landmark, const Eigen::Matrix3d& root,
                    Eigen::Ref<Eigen::MatrixXd> rows) {
  rows.topRows(landmark.calibration.rows()).noalias() = landmark.calibration * root.transpose();
  rows.bottomRows<1>() = (root * landmark.gradient).transpose();
}

// Landmarks in order of the time at which they are seen, so that a batch of them touches few control points.
std::vector<std::size_t> OrderByTime(const std::vector<LandmarkTies>& landmarks) {
  std::vector<double> mean(landmarks.size(), 0.0);
  std::vector<std::size_t> order(landmarks.size());
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    order[i] = i;
    for (const int column : landmarks[i].columns) mean[i] += column;
    if (!landmarks[i].columns.empty()) mean[i] /= static_cast<double>(landmarks[i].columns.size());
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return mean[a] < mean[b]; });
  return order;
}

// The rows of a batch of landmarks: the control points that any of them touches, one above the other, then
// the border's rows; three columns for each landmark.
struct Batch {
  std::vector<int> columns;  // of the control points, starts of 3
  Eigen::MatrixXd rows;
};

Batch GatherBatch(const std::vector<LandmarkTies>& landmarks, const std::size_t* order, std::size_t count,
                  int knots) {
  const int border = static_cast<int>(landmarks[order[0]].calibration.rows()) + 1;
  Batch batch;
  std::vector<int> row_of(knots / 3, -1);
  for (std::size_t k = 0; k < count; ++k) {
    for (const int column : landmarks[order[k]].columns) row_of[column / 3] = 0;
  }
  for (int i = 0; i < knots / 3; ++i) {
    if (row_of[i] < 0) continue;
    row_of[i] = 3 * static_cast<int>(batch.columns.size());
    batch.columns.push_back(3 * i);
  }
  const int touched = 3 * static_cast<int>(batch.columns.size());
  batch.rows.resize(touched + border, 3 * count);
  ParallelFor(count, [&](std::size_t k) {
    const LandmarkTies& landmark = landmarks[order[k]];
    const Eigen::Matrix3d root = InverseRoot(landmark.own);
    auto columns = batch.rows.middleCols<3>(3 * k);
    columns.topRows(touched).setZero();
    for (std::size_t b = 0; b < landmark.columns.size(); ++b) {
      columns.middleRows<3>(row_of[landmark.columns[b] / 3]).noalias() =
          landmark.blocks[b] * root.transpose();
    }
    FillBorderRows(landmark, root, columns.bottomRows(border));
  });
  return batch;
}

// Takes the products of a batch's rows out of the columns of some of its control points, [begin, end).
void SubtractProducts(const Batch& batch, std::size_t begin, std::size_t end, EnvelopeMatrix* A) {
  const int first = 3 * static_cast<int>(begin), stride = static_cast<int>(batch.rows.rows());
  const int width = 3 * static_cast<int>(end - begin), height = stride - first;
  const int border = static_cast<int>(A->border.rows());
  Eigen::MatrixXd product(height, width);
  MultiplyTransposed(height, width, static_cast<int>(batch.rows.cols()), 1.0, &batch.rows(first, 0), stride,
                     &batch.rows(first, 0), stride, 0.0, product.data(), height);
  for (std::size_t j = begin; j < end; ++j) {
    for (int c = 0; c < 3; ++c) {
      const int column = batch.columns[j] + c;
      const double* from = &product(0, column - batch.columns[j] + 3 * static_cast<int>(j - begin));
      double* to = A->Column(column) - EnvelopeMatrix::FirstRow(column);
      for (std::size_t i = j; i < batch.columns.size(); ++i) {
        const double* block = from + 3 * (i - begin);
        for (int r = 0; r < 3; ++r) to[batch.columns[i] + r] -= block[r];
      }
      A->border.col(column) -= Eigen::Map<const Eigen::VectorXd>(from + height - border, border);
    }
  }
}

// A -= sum over landmarks of W own^-1 W^T, where A holds the control points and as border the calibration and
// the gradient; the corner is the border's own.
void EliminateLandmarks(const std::vector<LandmarkTies>& landmarks, EnvelopeMatrix* A,
                        Eigen::MatrixXd* corner) {
  constexpr std::size_t kColumns = 32;  // control points in one task
  const BlasOnOneThread guard;
  const std::vector<std::size_t> order = OrderByTime(landmarks);
  const int border = static_cast<int>(corner->rows());
  for (std::size_t begin = 0; begin < order.size(); begin += kBatch) {
    const std::size_t count = std::min(order.size() - begin, kBatch);
    const Batch batch = GatherBatch(landmarks, &order[begin], count, A->size());
    const std::size_t parts = (batch.columns.size() + kColumns - 1) / kColumns;
    ParallelFor(parts + 1, [&](std::size_t part) {
      if (part < parts) {
        SubtractProducts(batch, part * kColumns, std::min(batch.columns.size(), (part + 1) * kColumns), A);
      } else {
        const auto rows = batch.rows.bottomRows(border);
        *corner -= rows * rows.transpose();
      }
    });
  }
}

// The same while the control points are held.
void EliminateLandmarksFromCorner(const std::vector<LandmarkTies>& landmarks, Eigen::MatrixXd* corner) {
  constexpr std::size_t kParts = 16;
  const Eigen::Index border = corner->rows();
  std::vector<Eigen::MatrixXd> sums(kParts, Eigen::MatrixXd::Zero(border, border));
  ParallelFor(kParts, [&](std::size_t part) {
    const std::size_t begin = landmarks.size() * part / kParts, end = landmarks.size() * (part + 1) / kParts;
    Eigen::MatrixXd rows(border, 3 * (end - begin));
    for (std::size_t k = begin; k < end; ++k) {
      FillBorderRows(landmarks[k], InverseRoot(landmarks[k].own), rows.middleCols<3>(3 * (k - begin)));
    }
    sums[part].noalias() = rows * rows.transpose();
  });
  for (const Eigen::MatrixXd& sum : sums) *corner -= sum;
}

// The last row that each control point's column reaches, by the band and by the landmarks that tie it.
std::vector<int> Reach(const Accumulator& sum, const std::vector<LandmarkTies>& landmarks) {
  const int knots = static_cast<int>(sum.band.cols()), bandwidth = static_cast<int>(sum.band.rows()) - 1;
  std::vector<int> reach(knots);
  for (int j = 0; j < knots; ++j) reach[j] = std::min(knots - 1, j + bandwidth);
  for (const LandmarkTies& landmark : landmarks) {
    if (landmark.columns.empty()) continue;
    const auto range = std::minmax_element(landmark.columns.begin(), landmark.columns.end());
    reach[*range.first] = std::max(reach[*range.first], *range.second + 2);
  }
  return reach;
}

EnvelopeMatrix KnotMatrix(const Accumulator& sum, const std::vector<LandmarkTies>& landmarks) {
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
  NormalSolution solution;
  solution.delta = Eigen::VectorXd::Zero(knots + calibration);
  // The calibration, and the gradient as one more row and column.
  Eigen::MatrixXd corner = Eigen::MatrixXd::Zero(calibration + 1, calibration + 1);
  corner.topLeftCorner(calibration, calibration) = sum.corner;
  corner.bottomLeftCorner(1, calibration) = sum.gradient_calibration.transpose();
  const auto solve_calibration = [&] {
    solution.information = corner.topLeftCorner(calibration, calibration).selfadjointView<Eigen::Lower>();
    solution.delta.tail(calibration) =
        SolveCalibration(solution.information, corner.bottomLeftCorner(1, calibration).transpose(), prior,
                         prior_gradient, free_calibration, damping);
  };
  if (hold_knots) {
    EliminateLandmarksFromCorner(landmarks, &corner);
    solve_calibration();
  } else {
    // Control points first; the calibration is what is left over, so its information comes out by the way.
    EnvelopeMatrix A = KnotMatrix(sum, landmarks);
    EliminateLandmarks(landmarks, &A, &corner);
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
  solution.solved = solution.delta.allFinite();
  return solution;
}

}  // namespace mlic
