#include "mlic_core/imu/hand_eye.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/imu/robust.h"

namespace mlic {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

constexpr double kShownSigma = 0.5 * M_PI / 180.0;  // from: definition, the limit of observable rotation
constexpr double kSmallestScale = 1e-6;             // from: guard, far below noise
constexpr double kNoGuessSigma = 10.0;              // rad, m; from: guard, wider than any answer

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

struct Residuals {
  Eigen::Vector3d rotation;  // grows by rotation_jacobian * step
  Eigen::Vector3d translation;
  Matrix36d rotation_jacobian;
  Matrix36d translation_jacobian;
};

Residuals Evaluate(const RelativeMotion& motion, const RigidTransform& T) {
  const Eigen::Quaterniond carried = T.rotation * motion.lidar.rotation * T.rotation.conjugate();
  const Eigen::Vector3d lidar_step = T.rotation * motion.lidar.translation;
  const Eigen::Matrix3d R_imu = motion.imu.rotation.toRotationMatrix();
  Residuals r;
  r.rotation = Log(Eigen::Quaterniond(motion.imu.rotation.conjugate() * carried));
  r.translation = R_imu * T.translation - T.translation - lidar_step + motion.imu.translation;
  r.rotation_jacobian.setZero();
  r.rotation_jacobian.leftCols<3>() = RightJacobianInverse(r.rotation) *
                                      (carried.conjugate().toRotationMatrix() - Eigen::Matrix3d::Identity());
  r.translation_jacobian << Hat(lidar_step), R_imu - Eigen::Matrix3d::Identity();
  return r;
}

struct System {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  Eigen::Matrix3d H_rotations = Eigen::Matrix3d::Zero();  // from the rotation equation alone
  double rotation_scale = 1.0;
  double translation_scale = 1.0;
  double inlier_share = 0.0;
  double cost = 0.0;  // robust, to compare starts
  // The weights of good residuals lie somewhat below 1, which takes nothing from the precision: H times this
  // is the information.
  double information_factor = 1.0;
};

System Linearize(const std::vector<RelativeMotion>& motions, const RigidTransform& T, bool redescending) {
  std::vector<Residuals> residuals;
  std::vector<double> rotation_norms, translation_norms;
  for (const RelativeMotion& motion : motions) {
    residuals.push_back(Evaluate(motion, T));
    rotation_norms.push_back(residuals.back().rotation.norm() / motion.sigma_rotation);
    translation_norms.push_back(residuals.back().translation.norm() / motion.sigma_translation);
  }
  System system;
  system.rotation_scale = std::max(kSmallestScale, SigmaFromNorms(rotation_norms));
  system.translation_scale = std::max(kSmallestScale, SigmaFromNorms(translation_norms));
  const auto weigh = [&](double norm, double scale) {
    return redescending ? TukeyWeight(norm, scale) : AbsoluteWeight(norm, scale);
  };
  double inliers = 0.0, weights = 0.0, square_weights = 0.0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    // A motion with a wrong rotation or a wrong translation is wrong as a whole.
    const double weight = weigh(rotation_norms[i], system.rotation_scale) *
                          weigh(translation_norms[i], system.translation_scale);
    const double rotation_sigma = motions[i].sigma_rotation * system.rotation_scale;
    const double translation_sigma = motions[i].sigma_translation * system.translation_scale;
    const double w_rotation = weight / (rotation_sigma * rotation_sigma);
    const double w_translation = weight / (translation_sigma * translation_sigma);
    const Residuals& r = residuals[i];
    const Matrix6d from_rotation = w_rotation * r.rotation_jacobian.transpose() * r.rotation_jacobian;
    system.H_rotations += from_rotation.topLeftCorner<3, 3>();
    system.H += from_rotation + w_translation * r.translation_jacobian.transpose() * r.translation_jacobian;
    system.b -= w_rotation * r.rotation_jacobian.transpose() * r.rotation +
                w_translation * r.translation_jacobian.transpose() * r.translation;
    inliers += weight > 0.0 ? 1.0 : 0.0;
    weights += weight;
    square_weights += weight * weight;
    system.cost += std::min(rotation_norms[i], 100.0) + std::min(translation_norms[i], 100.0);
  }
  system.information_factor = weights / std::max(square_weights, 1e-300);
  system.inlier_share = inliers / static_cast<double>(motions.size());
  return system;
}

struct Prior {
  RigidTransform T;
  Vector6d information;

  explicit Prior(const std::optional<ExtrinsicGuess>& guess) {
    information.setConstant(1.0 / (kNoGuessSigma * kNoGuessSigma));
    if (!guess) return;
    T = guess->T_imu_sensor;
    information << guess->sigma_rotation.array().square().inverse(),
        guess->sigma_translation.array().square().inverse();
  }

  void AddTo(const RigidTransform& at, System* system) const {
    const Eigen::Vector3d rotation = Log(Eigen::Quaterniond(at.rotation * T.rotation.conjugate()));
    const Eigen::Matrix3d J = RightJacobianInverse(-rotation);
    const auto Lambda = information.head<3>().asDiagonal();
    system->H.topLeftCorner<3, 3>() += J.transpose() * Lambda * J;
    system->b.head<3>() -= J.transpose() * (Lambda * rotation);
    system->H.diagonal().tail<3>() += information.tail<3>();
    system->b.tail<3>() -= information.tail<3>().cwiseProduct(at.translation - T.translation);
  }
};

RigidTransform Step(const RigidTransform& T, const Vector6d& step) {
  return {(ExpQuaternion(step.head<3>()) * T.rotation).normalized(), T.translation + step.tail<3>()};
}

struct Start {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d open_axis;  // IMU frame: what the rotations show least
  bool open = false;          // whether the rotation about it must be searched
};

Start SolveRotation(const std::vector<RelativeMotion>& motions, const std::optional<ExtrinsicGuess>& guess) {
  std::vector<double> mismatches;
  for (const RelativeMotion& m : motions) {
    const double difference = Log(m.imu.rotation).norm() - Log(m.lidar.rotation).norm();
    mismatches.push_back(std::abs(difference) / m.sigma_rotation);
  }
  const double scale = std::max(kSmallestScale, 1.4826 * Median(mismatches));
  std::vector<double> weights;
  for (const double mismatch : mismatches) weights.push_back(TukeyWeight(mismatch, scale));
  Start start;
  Eigen::Vector4d spectrum = Eigen::Vector4d::Zero();
  for (int iteration = 0; iteration < 6; ++iteration) {
    Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const Eigen::Matrix4d A =
          QuaternionEquation(Positive(motions[i].imu.rotation), Positive(motions[i].lidar.rotation));
      const double sigma = motions[i].sigma_rotation * scale;
      M += 4.0 * weights[i] / (sigma * sigma) * A.transpose() * A;
    }
    spectrum = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(M).eigenvalues();
    if (guess) {
      const Eigen::Vector4d q = guess->T_imu_sensor.rotation.coeffs();
      M +=
          4.0 / guess->sigma_rotation.squaredNorm() * 3.0 * (Eigen::Matrix4d::Identity() - q * q.transpose());
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(M);
    start.rotation = Eigen::Quaterniond(Eigen::Vector4d(eigen.eigenvectors().col(0)));
    // The neighbouring null direction, as a left rotation: q2 = (axis / 2) * q to first order.
    const Eigen::Quaterniond second(Eigen::Vector4d(eigen.eigenvectors().col(1)));
    start.open_axis = (second * start.rotation.conjugate()).vec().normalized();
    std::vector<double> norms;
    for (const RelativeMotion& m : motions) {
      norms.push_back(Evaluate(m, {start.rotation, Eigen::Vector3d::Zero()}).rotation.norm() /
                      m.sigma_rotation);
    }
    const double sigma = std::max(kSmallestScale, SigmaFromNorms(norms));
    for (std::size_t i = 0; i < motions.size(); ++i) weights[i] = TukeyWeight(norms[i], sigma);
  }
  // spectrum[1] - spectrum[0] is the information, 1/rad^2 times 4, about the open axis.
  start.open = !guess && spectrum[1] - spectrum[0] < 4.0 * 25.0 / (kShownSigma * kShownSigma);
  return start;
}

}  // namespace

HandEyeResult SolveHandEye(const std::vector<RelativeMotion>& motions,
                           const std::optional<ExtrinsicGuess>& guess, double overlap) {
  HandEyeResult result;
  if (motions.size() < 10) {
    result.failure = "fewer than 10 motions that IMU and LiDAR have in common";
    return result;
  }
  const Prior prior(guess);
  const Start start = SolveRotation(motions, guess);
  const auto refine = [&](const Eigen::Quaterniond& rotation, int iterations) {
    RigidTransform T{rotation, prior.T.translation};
    for (int i = 0; i < iterations; ++i) {
      System system = Linearize(motions, T, i >= 5);
      system.H /= overlap;
      system.b /= overlap;
      prior.AddTo(T, &system);
      Vector6d step = system.H.ldlt().solve(system.b);
      step *= std::min(1.0, 0.3 / (step.head<3>().norm() + 1e-300));
      T = Step(T, step);
      if (i > 6 && step.norm() < 1e-12) break;
    }
    return T;
  };
  RigidTransform T = refine(start.rotation, 5);
  if (start.open) {
    double least = Linearize(motions, T, false).cost;
    constexpr int kStarts = 12;
    for (int i = 1; i < kStarts; ++i) {
      const Eigen::Vector3d turn = start.open_axis * (2.0 * M_PI * i / kStarts);
      const RigidTransform candidate = refine(ExpQuaternion(turn) * start.rotation, 8);
      const double cost = Linearize(motions, candidate, false).cost;
      if (cost >= least) continue;
      least = cost;
      T = candidate;
    }
  }
  T = refine(T.rotation, 40);

  System system = Linearize(motions, T, true);
  result.valid = true;
  result.T_imu_lidar = T;
  result.rotation_scale = system.rotation_scale;
  result.translation_scale = system.translation_scale;
  result.inlier_share = system.inlier_share;
  const double factor = system.information_factor / overlap;
  system.H *= factor;
  result.information = system.H;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(Eigen::Matrix3d(factor * system.H_rotations));
  for (int i = 0; i < 3; ++i) {
    if (eigen.eigenvalues()[i] > 1.0 / (kShownSigma * kShownSigma)) ++result.rotation_directions_shown;
  }
  prior.AddTo(T, &system);
  result.covariance = system.H.ldlt().solve(Matrix6d::Identity());
  return result;
}

}  // namespace mlic
