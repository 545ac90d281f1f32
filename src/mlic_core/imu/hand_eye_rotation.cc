#include "mlic_core/imu/hand_eye_rotation.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/imu/robust.h"
#include "mlic_core/sensors/observability_limits.h"

namespace mlic {
namespace {

constexpr int kRounds = 6;  // of weights; from: guard

Eigen::Quaterniond Positive(const Eigen::Quaterniond& q) {
  return q.w() < 0.0 ? Eigen::Quaterniond(-q.coeffs()) : q;
}

// A with A * q = q_imu * q - q * q_lidar; q as (x, y, z, w).
Eigen::Matrix4d QuaternionEquation(const Eigen::Quaterniond& q_imu, const Eigen::Quaterniond& q_lidar) {
  const Eigen::Vector3d difference = q_imu.vec() - q_lidar.vec();
  Eigen::Matrix4d A;
  A.topLeftCorner<3, 3>() = (q_imu.w() - q_lidar.w()) * Eigen::Matrix3d::Identity() +
                            Hat(Eigen::Vector3d(q_imu.vec() + q_lidar.vec()));
  A.topRightCorner<3, 1>() = difference;
  A.bottomLeftCorner<1, 3>() = -difference.transpose();
  A(3, 3) = q_imu.w() - q_lidar.w();
  return A;
}

// rad, of the rotation equation.
double Mismatch(const RelativeMotion& m, const Eigen::Quaterniond& R) {
  return AngleBetween(m.imu.rotation, R * m.lidar.rotation * R.conjugate());
}

}  // namespace

HandEyeRotation SolveHandEyeRotation(const std::vector<RelativeMotion>& motions,
                                     const std::optional<ExtrinsicGuess>& guess) {
  std::vector<double> mismatches;
  for (const RelativeMotion& m : motions) {
    const double difference = Log(m.imu.rotation).norm() - Log(m.lidar.rotation).norm();
    mismatches.push_back(std::abs(difference) / m.sigma_rotation);
  }
  const double scale = std::max(kSmallestScale, 1.4826 * Median(mismatches));
  std::vector<double> weights;
  for (const double mismatch : mismatches) weights.push_back(TukeyWeight(mismatch, scale));
  HandEyeRotation start;
  Eigen::Vector4d spectrum = Eigen::Vector4d::Zero();
  for (int iteration = 0; iteration < kRounds; ++iteration) {
    Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const Eigen::Matrix4d A =
          QuaternionEquation(Positive(motions[i].imu.rotation), Positive(motions[i].lidar.rotation));
      const double sigma = motions[i].sigma_rotation * scale;
      M += 4.0 * weights[i] / (sigma * sigma) * A.transpose() * A;
    }
    spectrum = SymmetricEigen<Eigen::Dynamic>(M).eigenvalues();
    if (guess) {
      const Eigen::Vector4d q = guess->T_imu_sensor.rotation.coeffs();
      M +=
          4.0 / guess->sigma_rotation.squaredNorm() * 3.0 * (Eigen::Matrix4d::Identity() - q * q.transpose());
    }
    const SymmetricEigen<Eigen::Dynamic> eigen(M);
    start.R_imu_lidar = Eigen::Quaterniond(Eigen::Vector4d(eigen.eigenvectors().col(0)));
    // The neighbouring null direction, as a left rotation: q2 = (axis / 2) * q to first order.
    const Eigen::Quaterniond second(Eigen::Vector4d(eigen.eigenvectors().col(1)));
    start.open_axis = (second * start.R_imu_lidar.conjugate()).vec().normalized();
    std::vector<double> norms;
    for (const RelativeMotion& m : motions) {
      norms.push_back(Mismatch(m, start.R_imu_lidar) / m.sigma_rotation);
    }
    const double sigma = std::max(kSmallestScale, SigmaFromNorms(norms));
    for (std::size_t i = 0; i < motions.size(); ++i) weights[i] = TukeyWeight(norms[i], sigma);
  }
  // spectrum[1] - spectrum[0] is the information, 1/rad^2 times 4, about the open axis.
  start.open = !guess && spectrum[1] - spectrum[0] < 4.0 * 25.0 / (kRotationLimit * kRotationLimit);
  return start;
}

}  // namespace mlic
