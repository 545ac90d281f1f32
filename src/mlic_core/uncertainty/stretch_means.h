#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/problem/imu_terms.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// Means of an IMU's residuals, weighted by their variances, over the whole stretches of a drive of one
// length.
class StretchMeans {
 public:
  // length: s. residuals: at least one.
  StretchMeans(const ImuResiduals& residuals, const ImuSigmaCourse& sigma, double length);

  // By how much the squares of the means of three components, from `first` on, exceed what white noise leaves
  // of them, lessened by what chance allows (three standard deviations of a mean of squares). At least one
  // stretch.
  double Excess(int first) const;

 private:
  using Mean = Eigen::Matrix<double, 6, 1>;  // gyroscope, rad/s; accelerometer, m/s^2

  Mean Of(std::size_t stretch) const;

  std::vector<Mean> sums_;     // of residuals by their variances
  std::vector<Mean> weights_;  // of the inverse variances
};

}  // namespace mlic
