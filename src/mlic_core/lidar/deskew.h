#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <optional>

#include "mlic_core/geometry/rigid_transform.h"

namespace mlic {

// Rotation of the LiDAR between two times of its own clock, R_lidar(from)_lidar(to); when given, it replaces
// the constant-velocity assumption for rotation in de-skew and prediction. Nothing where the gyroscope did
// not measure all the time between them: scans there go without.
using RotationBetween = std::function<std::optional<Eigen::Quaterniond>(double from, double to)>;

// What a LiDAR's velocity v and position p gain between two times by the specific force, in its frame at the
// first: with its rotation R there, gravity g and T = to - from,
//   v(to) = v + g T + R * velocity,  p(to) = p + v T + g T^2/2 + R * position.
struct LinearGain {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
};

// What an IMU says of a LiDAR's motion, in times of the LiDAR's clock. Each may be empty.
struct InertialMotion {
  RotationBetween rotation;
  // Only between times whose rotation is known.
  std::function<LinearGain(double from, double to)> gain;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s^2, in the LiDAR's frame at its first scan
};

// Velocity of the LiDAR in its own frame at the middle of a scan, rad/s and m/s.
struct Twist {
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
};

// How the LiDAR moved during one scan: a point p measured s seconds after the middle of the scan is at
// Rotation(s) * p + s * linear in the LiDAR's frame at the middle.
//
// Rotation(s) is Exp(s * angular + s^2 / 2 * angular_acceleration), or the gyroscope's R(middle, middle + s).
// It is tabulated, and interpolated linearly between entries: the error is (angle between entries)^2 / 8,
// below 1e-4 rad at 500 deg/s.
class ScanMotion {
 public:
  // half_span: the largest |s|. rotation_between must know the rotations of all of the scan.
  ScanMotion(const Twist& twist, const Eigen::Vector3d& angular_acceleration, double half_span);
  ScanMotion(const RotationBetween& rotation_between, double middle, double half_span);

  void SetLinear(const Eigen::Vector3d& linear) { linear_ = linear; }

  Eigen::Vector3d ToMiddle(const Eigen::Vector3d& p, double s) const {
    const double position = std::clamp((s + half_span_) * entries_per_second_, 0.0, kEntries - 1.0);
    const int entry = static_cast<int>(position);
    return rotations_[entry] * p + (position - entry) * (differences_[entry] * p) + s * linear_;
  }

 private:
  static constexpr int kEntries = 33;  // from: structural
  void FillDifferences();
  double TimeOf(int entry) const { return entry / entries_per_second_ - half_span_; }

  double half_span_;
  double entries_per_second_;
  Eigen::Vector3d linear_ = Eigen::Vector3d::Zero();
  std::array<Eigen::Matrix3d, kEntries> rotations_;
  std::array<Eigen::Matrix3d, kEntries> differences_;  // to the next entry
};

}  // namespace mlic
