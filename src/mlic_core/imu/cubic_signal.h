#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// A sampled vector signal, interpolated by a cubic in each interval (Hermite, with the three-point derivative
// at the samples): the error falls with the fourth power of the period, where that of straight lines, which
// costs a 100 Hz gyroscope some 1e-4 rad in a quick turn, falls with the second.
class CubicSignal {
 public:
  CubicSignal() = default;
  // Two samples or more with increasing times. Intervals longer than longest_bridged do not take part in the
  // derivatives of their neighbours.
  CubicSignal(const std::vector<double>& times, std::vector<Eigen::Vector3d> values, double longest_bridged);

  const Eigen::Vector3d& Sample(std::size_t i) const { return values_[i]; }

  // The value s seconds after sample i, for s in [0, length of interval i]; i is not the last sample.
  Eigen::Vector3d Value(std::size_t i, double s) const;

 private:
  std::vector<double> lengths_;  // of the intervals, s
  std::vector<Eigen::Vector3d> values_;
  std::vector<Eigen::Vector3d> derivatives_;
};

}  // namespace mlic
