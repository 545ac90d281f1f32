#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/problem/imu_terms.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// Means of an IMU's residuals over the whole stretches of a drive of one length.
class StretchMeans {
 public:
  using Mean = Eigen::Matrix<double, 6, 1>;  // gyroscope, rad/s; accelerometer, m/s^2

  // length: s. residuals: at least one.
  StretchMeans(const ImuResiduals& residuals, const ImuSigma& sigma, double length);

  std::size_t Count() const { return sums_.size(); }
  Mean Of(std::size_t stretch) const;
  // What white noise of the sigmas leaves of a mean of as many samples as a stretch has in the mean.
  Mean Noise() const;
  // By how much the squares of the means of three components, from `first` on, exceed what white noise leaves
  // of them, lessened by what chance allows (three standard deviations of a mean of squares). At least one
  // stretch.
  double Excess(int first) const;

 private:
  Mean sigma_;
  std::vector<Mean> sums_;
  std::vector<double> samples_;
};

}  // namespace mlic
