#pragma once

#include <array>

#include "mlic_core/imu/imu_sigma_course.h"
#include "mlic_core/problem/imu_terms.h"
#include "mlic_core/trajectory/split_spline.h"

namespace mlic {

// Sigmas of single samples as weights, from residuals after a solve (docs/method.md, section 3.1): for each
// axis the largest of `given`, the robust scatter of the residuals (vibration that the spline cannot follow)
// and the noise's density just above what the splines follow, from half to once the knots' rate, times the
// root of the IMU's rate: a sensor's low-pass takes from the scatter, not from the density of slow noise.
// Stretches of 4 s whose sigmas exceed the usual ones by more than chance have their own.
ImuSigmaCourse MeasureImuSigma(const ImuResiduals& residuals, const SplitSpline& trajectory,
                               const ImuSigma& given);

// By how much the squares of residuals' means over some seconds exceed what white noise of the sigmas leaves
// of them; of gyroscope and accelerometer. One: by nothing beyond chance.
struct ImuMeanExcess {
  std::array<double, 2> variance{1.0, 1.0};
  std::array<double, 2> seconds{0.0, 0.0};  // over which it was found; 0: none
};

// The largest excess of lengths from 1 to 10 s, over the drive's whole stretches of that length, lessened by
// what chance allows (three standard deviations of a mean of squares).
ImuMeanExcess MeasureMeanExcess(const ImuResiduals& residuals, const ImuSigmaCourse& sigma);

}  // namespace mlic
