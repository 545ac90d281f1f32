#include "mlic_core/imu/gyro_integration.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/imu/imu_samples.h"

namespace mlic {
namespace {

// Integral of Exp(theta(s)) over [0, s] by Simpson's rule.
Eigen::Matrix3d IntegrateRotation(const Eigen::Vector3d& half_way, const Eigen::Vector3d& whole, double s) {
  return s / 6.0 * (Eigen::Matrix3d::Identity() + 4.0 * ExpMatrix(half_way) + ExpMatrix(whole));
}

}  // namespace

GyroIntegration::GyroIntegration(const std::vector<ImuSample>& samples, const Eigen::Vector3d& bias) {
  const std::vector<ImuSample> ordered = OrderedFiniteSamples(samples);
  longest_bridged_ = LongestBridgedPeriod(MedianPeriod(ordered));
  const std::size_t n = ordered.size();
  std::vector<Eigen::Vector3d> rates(n);
  times_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    times_[i] = ordered[i].time;
    rates[i] = ordered[i].angular_velocity - bias;
  }
  rates_ = CubicSignal(times_, std::move(rates), longest_bridged_);

  rotations_.resize(n, Eigen::Quaterniond::Identity());
  rotation_integrals_.resize(n, Eigen::Matrix3d::Zero());
  gaps_before_.resize(n, 0);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = times_[i + 1] - times_[i];
    const Eigen::Vector3d increment = IncrementWithin(i, h);
    rotations_[i + 1] = (rotations_[i] * ExpQuaternion(increment)).normalized();
    rotation_integrals_[i + 1] =
        rotation_integrals_[i] +
        rotations_[i].toRotationMatrix() * IntegrateRotation(IncrementWithin(i, 0.5 * h), increment, h);
    gaps_before_[i + 1] = gaps_before_[i] + (h > longest_bridged_ ? 1 : 0);
  }
}

std::size_t GyroIntegration::IntervalAt(double time) const {
  const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, time);
  return static_cast<std::size_t>(after - times_.begin()) - 1;
}

bool GyroIntegration::Covers(double t0, double t1) const {
  if (t0 > t1) std::swap(t0, t1);
  if (!(t0 >= Start() && t1 <= End())) return false;
  return gaps_before_[IntervalAt(t1) + 1] == gaps_before_[IntervalAt(t0)];
}

Eigen::Vector3d GyroIntegration::IncrementWithin(std::size_t interval, double s) const {
  static const double kGauss = std::sqrt(3.0) / 6.0;  // from: derivation, nodes of Gauss-Legendre quadrature
  const Eigen::Vector3d w1 = rates_.Value(interval, (0.5 - kGauss) * s);
  const Eigen::Vector3d w2 = rates_.Value(interval, (0.5 + kGauss) * s);
  return 0.5 * s * (w1 + w2) + 0.5 * kGauss * s * s * w1.cross(w2);
}

Eigen::Quaterniond GyroIntegration::RotationTo(double time) const {
  if (time < Start()) return ExpQuaternion(rates_.Sample(0) * (time - Start()));
  if (time > End())
    return rotations_.back() * ExpQuaternion(rates_.Sample(times_.size() - 1) * (time - End()));
  const std::size_t i = IntervalAt(time);
  return rotations_[i] * ExpQuaternion(IncrementWithin(i, time - times_[i]));
}

Eigen::Quaterniond GyroIntegration::RotationBetween(double t0, double t1) const {
  return RotationTo(t0).conjugate() * RotationTo(t1);
}

Eigen::Vector3d GyroIntegration::AngularVelocity(double time) const {
  if (time <= Start()) return rates_.Sample(0);
  if (time >= End()) return rates_.Sample(times_.size() - 1);
  const std::size_t i = IntervalAt(time);
  return rates_.Value(i, time - times_[i]);
}

Eigen::Matrix3d GyroIntegration::RotationIntegral(double time) const {
  if (time < Start()) {
    const Eigen::Vector3d whole = rates_.Sample(0) * (time - Start());
    return IntegrateRotation(0.5 * whole, whole, time - Start());
  }
  const std::size_t last = times_.size() - 1;
  const std::size_t i = time > End() ? last : IntervalAt(time);
  const double s = time - times_[i];
  const Eigen::Vector3d half_way =
      i == last ? Eigen::Vector3d(rates_.Sample(i) * (0.5 * s)) : IncrementWithin(i, 0.5 * s);
  const Eigen::Vector3d whole = i == last ? Eigen::Vector3d(rates_.Sample(i) * s) : IncrementWithin(i, s);
  return rotation_integrals_[i] + rotations_[i].toRotationMatrix() * IntegrateRotation(half_way, whole, s);
}

Eigen::Matrix3d GyroIntegration::BiasJacobian(double t0, double t1) const {
  return -(RotationTo(t1).conjugate().toRotationMatrix() * (RotationIntegral(t1) - RotationIntegral(t0)));
}

}  // namespace mlic
