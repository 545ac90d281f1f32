#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "mlic_core/imu/cubic_signal.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// The IMU's rotation between any two times, integrated once from the gyroscope. Times: seconds on the IMU
// clock.
//
// Between samples the rate is a cubic; each interval is integrated by the fourth-order Magnus expansion at
// the two Gauss points, R' = R * Hat(w):
//   theta = h/2 (w1 + w2) + sqrt(3)/12 h^2 (w1 x w2)
// Before the first and after the last sample the rate is taken as constant.
class GyroIntegration {
 public:
  // Samples that are not finite or not in order are left out. bias (rad/s) is subtracted from the samples.
  explicit GyroIntegration(const std::vector<ImuSample>& samples,
                           const Eigen::Vector3d& bias = Eigen::Vector3d::Zero());

  double Start() const { return times_.front(); }
  double End() const { return times_.back(); }

  // Whether all of [t0, t1] (in either order) lies within the samples and no gap is in it.
  bool Covers(double t0, double t1) const;

  // R_imu(t0)_imu(t1): maps vectors of the IMU frame at t1 into the IMU frame at t0.
  Eigen::Quaterniond RotationBetween(double t0, double t1) const;

  // The same from the first sample to t.
  Eigen::Quaterniond RotationTo(double time) const;

  // Less the bias; IMU frame, rad/s.
  Eigen::Vector3d AngularVelocity(double time) const;

  // d rho / d bias, where RotationBetween(t0, t1) * Exp(rho) is the rotation with a changed bias (s).
  Eigen::Matrix3d BiasJacobian(double t0, double t1) const;

  // Access for integration of what else the IMU measures: the interval that holds `time`, and in it the
  // rotation vector from its first sample to s seconds later.
  std::size_t IntervalAt(double time) const;
  Eigen::Vector3d IncrementWithin(std::size_t interval, double s) const;
  const std::vector<double>& times() const { return times_; }
  const std::vector<Eigen::Quaterniond>& rotations() const { return rotations_; }
  double longest_bridged() const { return longest_bridged_; }

  // Integral of RotationTo from the first sample to `time` (s).
  Eigen::Matrix3d RotationIntegral(double time) const;

 private:
  std::vector<double> times_;
  double longest_bridged_ = 0.0;
  CubicSignal rates_;
  std::vector<Eigen::Quaterniond> rotations_;        // from the first sample to each
  std::vector<Eigen::Matrix3d> rotation_integrals_;  // of RotationTo, to each sample
  std::vector<int> gaps_before_;                     // how many intervals before each sample are gaps
};

}  // namespace mlic
