#include "mlic_core/imu/specific_force_integration.h"

#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/imu/imu_samples.h"

namespace mlic {

SpecificForceIntegration::SpecificForceIntegration(const std::vector<ImuSample>& samples,
                                                   const Eigen::Vector3d& gyroscope_bias)
    : gyro_(samples, gyroscope_bias) {
  const std::vector<ImuSample> ordered = OrderedFiniteSamples(samples);
  std::vector<Eigen::Vector3d> forces(ordered.size());
  for (std::size_t i = 0; i < ordered.size(); ++i) forces[i] = ordered[i].specific_force;
  forces_ = CubicSignal(gyro_.times(), std::move(forces), gyro_.longest_bridged());
  integrals_.resize(ordered.size());
  for (std::size_t i = 0; i + 1 < ordered.size(); ++i) {
    integrals_[i + 1] = Advance(i, gyro_.times()[i + 1] - gyro_.times()[i]);
  }
}

SpecificForceIntegration::Integrals SpecificForceIntegration::Advance(std::size_t interval, double s) const {
  static const double kGauss = std::sqrt(3.0) / 6.0;  // from: derivation, nodes of Gauss-Legendre quadrature
  const Integrals& before = integrals_[interval];
  const Eigen::Matrix3d start = gyro_.rotations()[interval].toRotationMatrix();
  Integrals after = before;
  after.position += s * before.velocity;
  after.rotation_twice += s * before.rotation;
  for (const double fraction : {0.5 - kGauss, 0.5 + kGauss}) {
    const double at = fraction * s;
    const Eigen::Matrix3d rotation = start * ExpMatrix(gyro_.IncrementWithin(interval, at));
    const Eigen::Vector3d force = rotation * forces_.Value(interval, at);
    after.velocity += 0.5 * s * force;
    after.position += 0.5 * s * (s - at) * force;
    after.rotation += 0.5 * s * rotation;
    after.rotation_twice += 0.5 * s * (s - at) * rotation;
  }
  return after;
}

SpecificForceIntegration::Integrals SpecificForceIntegration::To(double time) const {
  const std::size_t i = gyro_.IntervalAt(time);
  return Advance(i, time - gyro_.times()[i]);
}

Eigen::Vector3d SpecificForceIntegration::Position(double t0, double t1) const {
  const Integrals from = To(t0);
  const Integrals to = To(t1);
  return gyro_.RotationTo(t0).conjugate() * (to.position - from.position - (t1 - t0) * from.velocity);
}

Eigen::Matrix3d SpecificForceIntegration::PositionBiasJacobian(double t0, double t1) const {
  const Integrals from = To(t0);
  const Integrals to = To(t1);
  return gyro_.RotationTo(t0).conjugate().toRotationMatrix() *
         (to.rotation_twice - from.rotation_twice - (t1 - t0) * from.rotation);
}

Eigen::Vector3d SpecificForceIntegration::Velocity(double t0, double t1) const {
  return gyro_.RotationTo(t0).conjugate() * (To(t1).velocity - To(t0).velocity);
}

Eigen::Matrix3d SpecificForceIntegration::VelocityBiasJacobian(double t0, double t1) const {
  return gyro_.RotationTo(t0).conjugate().toRotationMatrix() * (To(t1).rotation - To(t0).rotation);
}

}  // namespace mlic
