#include "mlic_core/uncertainty/imu_alignment.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/uncertainty/observability.h"

namespace mlic {
namespace {

// Covariances of the sensors' rotations to the axes of both of the IMU's sensors, in the mean over the
// sensors.
struct RotationCovariances {
  Eigen::Matrix3d to_gyroscope = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d to_accelerometer = Eigen::Matrix3d::Zero();
};

// axes: CalibrationState::accelerometer_axes, to which the covariance is.
RotationCovariances CovariancesOfRotations(const FreeAlignment& of, int alignment,
                                           const Eigen::Matrix3d& axes) {
  RotationCovariances mean;
  for (std::size_t s = 0; s < of.fixed.size(); ++s) {
    if (of.fixed[s]) continue;
    const auto rotation = of.covariance.block<3, 3>(Layout::Sensor(s), Layout::Sensor(s));
    const auto common = of.covariance.block<3, 3>(Layout::Sensor(s), alignment);
    // Of a rotation turned by `share` of what the accelerometer is.
    const auto turned = [&](const Eigen::Matrix3d& share) {
      const Eigen::Matrix3d cross = common * share;
      return Eigen::Matrix3d(rotation + cross + cross.transpose() +
                             share * of.covariance.block<3, 3>(alignment, alignment) * share);
    };
    const auto count = static_cast<double>(of.fixed.size());
    mean.to_gyroscope += turned(-axes) / count;
    mean.to_accelerometer += turned(Eigen::Matrix3d::Identity() - axes) / count;
  }
  return mean;
}

}  // namespace

AlignmentReview ReviewAlignment(const JointProblem& problem, const CalibrationState& state,
                                const Eigen::MatrixXd& information, double prior_sigma) {
  constexpr double kWellBelow = 1.0 / 3.0;  // of the prior; from: derivation, its information is a tenth
  AlignmentReview review;
  const Layout layout(state, problem.estimate_imu_matrices);
  if (information.rows() != layout.calibration) return review;
  const int at = layout.alignment;
  const FreeAlignment of_data = CovarianceWithAlignment(problem, state, information, Eigen::Matrix3d::Zero());
  const SymmetricEigen<3> eigen(Eigen::Matrix3d(of_data.covariance.block<3, 3>(at, at)));
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
    const double sigma = std::sqrt(std::max(0.0, eigen.eigenvalues()[i]));
    if (sigma < kWellBelow * prior_sigma) review.shown += axis * axis.transpose();
  }
  const Eigen::Matrix3d others = Eigen::Matrix3d::Identity() - review.shown;
  const FreeAlignment with_prior =
      CovarianceWithAlignment(problem, state, information, others / (prior_sigma * prior_sigma));
  review.covariance = with_prior.covariance.block<3, 3>(at, at);
  const RotationCovariances rotations = CovariancesOfRotations(with_prior, at, state.accelerometer_axes);
  const SymmetricEigen<3> gain(Eigen::Matrix3d(rotations.to_gyroscope - rotations.to_accelerometer));
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = gain.eigenvectors().col(i);
    if (gain.eigenvalues()[i] > 0.0) review.accelerometer_axes += axis * axis.transpose();
  }
  return review;
}

}  // namespace mlic
