#include "mlic_core/geometry/so3.h"

#include <cmath>

namespace mlic {
namespace {

// Below this squared angle series are used; their truncation error is under 1e-16 there.
constexpr double kSmallSquaredAngle = 1e-6;  // from: derivation

}  // namespace

Eigen::Matrix3d Hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Eigen::Quaterniond ExpQuaternion(const Eigen::Vector3d& v) {
  const double squared = v.squaredNorm();
  double w, scale;
  if (squared < kSmallSquaredAngle) {
    w = 1.0 - squared / 8.0 + squared * squared / 384.0;
    scale = 0.5 - squared / 48.0 + squared * squared / 3840.0;
  } else {
    const double angle = std::sqrt(squared);
    w = std::cos(0.5 * angle);
    scale = std::sin(0.5 * angle) / angle;
  }
  return Eigen::Quaterniond(w, scale * v.x(), scale * v.y(), scale * v.z());
}

Eigen::Matrix3d ExpMatrix(const Eigen::Vector3d& v) {
  const double squared = v.squaredNorm();
  double a, b;
  if (squared < kSmallSquaredAngle) {
    a = 1.0 - squared / 6.0 + squared * squared / 120.0;
    b = 0.5 - squared / 24.0 + squared * squared / 720.0;
  } else {
    const double angle = std::sqrt(squared);
    const double half = std::sin(0.5 * angle);
    a = std::sin(angle) / angle;
    b = 2.0 * half * half / squared;
  }
  const Eigen::Matrix3d hat = Hat(v);
  return Eigen::Matrix3d::Identity() + a * hat + b * hat * hat;
}

Eigen::Vector3d Log(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d vec = sign * q.vec();
  const double w = sign * q.w();
  const double sine = vec.norm();
  if (sine < 1e-4) {
    const double ratio = sine / w;
    return (2.0 / w) * (1.0 - ratio * ratio / 3.0) * vec;
  }
  return (2.0 * std::atan2(sine, w) / sine) * vec;
}

Eigen::Vector3d Log(const Eigen::Matrix3d& R) { return Log(Eigen::Quaterniond(R)); }

Eigen::Matrix3d RightJacobianInverse(const Eigen::Vector3d& v) {
  const double squared = v.squaredNorm();
  double b;
  if (squared < kSmallSquaredAngle) {
    b = 1.0 / 12.0 + squared / 720.0 + squared * squared / 30240.0;
  } else {
    const double half = 0.5 * std::sqrt(squared);
    b = (1.0 - half * std::cos(half) / std::sin(half)) / squared;
  }
  const Eigen::Matrix3d hat = Hat(v);
  return Eigen::Matrix3d::Identity() + 0.5 * hat + b * hat * hat;
}

Eigen::Quaterniond FromRollPitchYaw(const Eigen::Vector3d& rpy) {
  return Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX());
}

Eigen::Vector3d ToRollPitchYaw(const Eigen::Quaterniond& q) {
  const Eigen::Matrix3d R = q.normalized().toRotationMatrix();
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2)));
  // At gimbal lock only yaw - roll (or their sum) is defined: roll is set to zero.
  if (std::hypot(R(2, 1), R(2, 2)) < 1e-9) return {0.0, pitch, std::atan2(-R(0, 1), R(1, 1))};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return Log(a.conjugate() * b).norm();
}

}  // namespace mlic
