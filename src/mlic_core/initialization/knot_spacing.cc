#include "mlic_core/initialization/knot_spacing.h"

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <functional>

#include "mlic_core/common/order_statistics.h"

namespace mlic {
namespace {

constexpr double kTolerance = 1.01;  // of the residual variance

// Residual variance of a least-squares fit by a uniform B-spline of the given degree (1 or 2); summed over
// the axes.
double FitVariance(const std::vector<ImuSample>& imu, double spacing, int degree,
                   const std::function<Eigen::Vector3d(const ImuSample&)>& signal) {
  const double start = imu.front().time;
  const int segments = std::max(1, static_cast<int>(std::ceil((imu.back().time - start) / spacing)));
  const int count = segments + degree;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 3);
  std::vector<Eigen::Vector4d> weights(imu.size());
  std::vector<int> first(imu.size());
  Eigen::MatrixXd band = Eigen::MatrixXd::Zero(3, count);
  for (std::size_t k = 0; k < imu.size(); ++k) {
    const double at = (imu[k].time - start) / spacing;
    first[k] = std::min(segments - 1, static_cast<int>(at));
    const double u = at - first[k];
    weights[k] = degree == 1
                     ? Eigen::Vector4d(1.0 - u, u, 0.0, 0.0)
                     : Eigen::Vector4d(0.5 * (1.0 - u) * (1.0 - u), 0.5 + u - u * u, 0.5 * u * u, 0.0);
    const Eigen::Vector3d value = signal(imu[k]);
    for (int i = 0; i <= degree; ++i) {
      right.row(first[k] + i) += weights[k][i] * value.transpose();
      for (int j = 0; j <= i; ++j) band(i - j, first[k] + j) += weights[k][i] * weights[k][j];
    }
  }
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < 3 && j + i < count; ++i) {
      entries.emplace_back(j + i, j, band(i, j) + (i == 0 ? 1e-9 : 0.0));
    }
  }
  Eigen::SparseMatrix<double> normal(count, count);
  normal.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(normal);
  const Eigen::MatrixXd fit = solver.solve(right);
  double squares = 0.0;
  for (std::size_t k = 0; k < imu.size(); ++k) {
    Eigen::Vector3d residual = signal(imu[k]);
    for (int i = 0; i <= degree; ++i) residual -= weights[k][i] * fit.row(first[k] + i).transpose();
    squares += residual.squaredNorm();
  }
  return squares / std::max<double>(1.0, static_cast<double>(imu.size()) - count);
}

double Choose(const std::vector<ImuSample>& imu, double lidar_period, int degree,
              const std::function<Eigen::Vector3d(const ImuSample&)>& signal) {
  constexpr double kFinest = 0.04;
  const double finest = std::max(kFinest, 2.0 * MedianPeriod(imu));
  constexpr double kStep = 1.25;  // from: structural, steps of the search
  constexpr double kCoarsest = 0.2;
  double best = FitVariance(imu, finest, degree, signal);
  double chosen = finest;
  for (double spacing = finest * kStep; spacing <= std::max(kCoarsest, finest); spacing *= kStep) {
    const double variance = FitVariance(imu, spacing, degree, signal);
    best = std::min(best, variance);
    if (variance <= kTolerance * best) chosen = spacing;
  }
  return chosen > finest ? chosen : std::min(chosen, std::max(kFinest, lidar_period));
}

}  // namespace

KnotSpacing ChooseKnotSpacing(const std::vector<ImuSample>& imu, double lidar_period) {
  KnotSpacing spacing;
  spacing.rotation = Choose(imu, lidar_period, 2, [](const ImuSample& s) { return s.angular_velocity; });
  spacing.position = Choose(imu, lidar_period, 1, [](const ImuSample& s) { return s.specific_force; });
  return spacing;
}

}  // namespace mlic
