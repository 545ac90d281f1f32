#include "mlic_core/uncertainty/imu_alignment.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/sensors/imu_matrices.h"
#include "mlic_core/uncertainty/observability.h"

namespace mlic {
namespace {

constexpr double kWellBelow =
    1.0 / 3.0;                     // of the prior; from: derivation, holding then is ten times the variance
constexpr double kMuchLost = 2.0;  // of a sensor's sigma; from: definition
constexpr double kNoticed = 4.0;   // sigmas; from: derivation, by chance in 1 of 5000 drives' three axes

// By how much the sigma of the rotation of some sensor about the axis grows where the alignment about it is
// free.
double LossOfSensors(const Eigen::MatrixXd& covariance, const std::vector<bool>& fixed, int alignment,
                     const Eigen::Vector3d& axis, double variance) {
  double loss = 1.0;
  for (std::size_t s = 0; s < fixed.size(); ++s) {
    if (fixed[s]) continue;
    const int at = Layout::Sensor(s);
    const double own = axis.dot(covariance.block<3, 3>(at, at) * axis);
    const double shared = axis.dot(covariance.block<3, 3>(at, alignment) * axis);
    const double held = std::max(own - shared * shared / variance, 1e-6 * own);
    loss = std::max(loss, std::sqrt(own / held));
  }
  return loss;
}

}  // namespace

AlignmentReview ReviewAlignment(const JointProblem& problem, const CalibrationState& state,
                                const Eigen::MatrixXd& information, double prior_sigma, bool tried) {
  AlignmentReview review;
  review.covariance *= prior_sigma * prior_sigma;
  const Layout layout(state, problem.estimate_imu_matrices);
  if (information.rows() != layout.calibration) return review;
  const FreeAlignment free = CovarianceWithFreeAlignment(problem, state, information);
  const int at = layout.alignment;
  const SymmetricEigen<3> eigen(Eigen::Matrix3d(free.covariance.block<3, 3>(at, at)));
  const Eigen::Vector3d found = Log(SplitAccelerometerMatrix(state.accelerometer_matrix).rotation);
  review.held.setZero();
  review.covariance.setZero();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
    const double variance = std::max(eigen.eigenvalues()[i], 1e-18);
    const bool was_free = axis.dot(problem.imu.alignment_held * axis) < 0.5;
    bool is_free = std::sqrt(variance) < kWellBelow * prior_sigma;
    if (is_free && LossOfSensors(free.covariance, free.fixed, at, axis, variance) > kMuchLost) {
      is_free = was_free ? std::abs(axis.dot(found)) > kNoticed * std::sqrt(variance) : !tried;
      review.taken_back |= was_free && !is_free;
    }
    const Eigen::Matrix3d projector = axis * axis.transpose();
    if (!is_free) review.held += projector;
    review.covariance += (is_free ? variance : prior_sigma * prior_sigma) * projector;
  }
  if (review.held.trace() > 2.5) review.held.setIdentity();
  return review;
}

}  // namespace mlic
