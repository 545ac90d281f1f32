#include "mlic_core/lidar/deskew.h"

#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

constexpr double kShortestHalfSpan = 1e-4;  // s: scans whose points all have one time; from: guard

}  // namespace

ScanMotion::ScanMotion(const Twist& twist, const Eigen::Vector3d& angular_acceleration, double half_span)
    : half_span_(std::max(half_span, kShortestHalfSpan)),
      entries_per_second_((kEntries - 1) / (2.0 * half_span_)),
      linear_(twist.linear) {
  for (int i = 0; i < kEntries; ++i) {
    const double s = TimeOf(i);
    rotations_[i] = ExpMatrix(s * twist.angular + 0.5 * s * s * angular_acceleration);
  }
  FillDifferences();
}

ScanMotion::ScanMotion(const RotationBetween& rotation_between, double middle, double half_span)
    : half_span_(std::max(half_span, kShortestHalfSpan)),
      entries_per_second_((kEntries - 1) / (2.0 * half_span_)) {
  for (int i = 0; i < kEntries; ++i) {
    rotations_[i] = rotation_between(middle, middle + TimeOf(i)).value().toRotationMatrix();
  }
  FillDifferences();
}

void ScanMotion::FillDifferences() {
  for (int i = 0; i + 1 < kEntries; ++i) differences_[i] = rotations_[i + 1] - rotations_[i];
  differences_.back().setZero();
}

}  // namespace mlic
