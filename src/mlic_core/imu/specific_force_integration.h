#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/imu/cubic_signal.h"
#include "mlic_core/imu/gyro_integration.h"

namespace mlic {

// Integrals of the accelerometer in the rotating IMU frame between any two times, integrated once.
// With the IMU's position p, velocity v, rotation R in an inertial frame with gravity g and the
// accelerometer's bias b:
//   p(t1) = p(t0) + v(t0) T + g T^2/2 + R(t0) * (Position(t0, t1) - PositionBiasJacobian(t0, t1) * b),  T =
//   t1 - t0
// Both times lie within the samples; t1 may be before t0. Two-point Gauss quadrature in each interval (fourth
// order).
class SpecificForceIntegration {
 public:
  SpecificForceIntegration(const std::vector<ImuSample>& samples, const Eigen::Vector3d& gyroscope_bias);

  const GyroIntegration& gyro() const { return gyro_; }

  // m, in the IMU frame at t0.
  Eigen::Vector3d Position(double t0, double t1) const;
  // s^2.
  Eigen::Matrix3d PositionBiasJacobian(double t0, double t1) const;
  // v(t1) = v(t0) + g T + R(t0) * (Velocity(t0, t1) - VelocityBiasJacobian(t0, t1) * b); m/s, in the IMU
  // frame at t0, and s.
  Eigen::Vector3d Velocity(double t0, double t1) const;
  Eigen::Matrix3d VelocityBiasJacobian(double t0, double t1) const;

 private:
  // Integrals from the first sample to a time, in the IMU frame of the first sample: of the specific force
  // once and twice, of the rotation once and twice.
  struct Integrals {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d rotation_twice = Eigen::Matrix3d::Zero();
  };
  Integrals Advance(std::size_t interval, double s) const;
  Integrals To(double time) const;

  GyroIntegration gyro_;
  CubicSignal forces_;
  std::vector<Integrals> integrals_;  // to each sample
};

}  // namespace mlic
