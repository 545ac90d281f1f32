#pragma once

#include <optional>

#include "mlic_core/problem/imu_terms.h"
#include "mlic_core/sensors/bias_course.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// How the biases of a drive's IMU wander, as a BiasCourse has it.
struct BiasWander {
  double start = 0.0, spacing = 0.0;  // s
  std::size_t intervals = 0;          // of the course, one less than knots
  BiasSteps steps;                    // from one mean to the next, what noise leaves of means taken out
};

// From residuals with constant biases: none where their means over the course's intervals are no larger than
// white noise of the sigmas leaves of them, and where the drive is shorter than 10 s. Warming up, consumer
// gyroscopes wander by some mrad/s within a minute. docs/method.md, section 10.
std::optional<BiasWander> FindBiasWander(const ImuResiduals& residuals, const ImuSigmaCourse& sigma);

}  // namespace mlic
