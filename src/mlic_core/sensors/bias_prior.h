#pragma once

namespace mlic {

// Standard deviations of the priors about no bias.
// from: standard, zero-g offsets in the data sheets of consumer MEMS: 40 to 80 mg.
constexpr double kAccelerometerBiasSigma = 0.5;  // m/s^2
// from: standard, zero-rate offsets in the data sheets of consumer MEMS: 1 to 5 deg/s.
constexpr double kGyroscopeBiasSigma = 0.05;  // rad/s

}  // namespace mlic
