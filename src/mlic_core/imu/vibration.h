#pragma once

#include <optional>
#include <vector>

#include "mlic_core/sensors/measurements.h"

namespace mlic {

// Samples without the vibration that no trajectory follows.
struct FilteredImu {
  std::vector<ImuSample> samples;
  double above = 0.0;  // Hz, from where on nothing is left
  // Root mean squares of what was taken away, the largest of three axes.
  double angular_velocity = 0.0;  // rad/s
  double specific_force = 0.0;    // m/s^2
  // From where on the rates alone were low-passed besides, zero: nowhere, and what that took away.
  double turns_above = 0.0;  // Hz
  double fast_turns = 0.0;   // rad/s, rms, the largest of three axes
};

// Trajectories follow an IMU up to 12.5 Hz at most (kFinestKnots). Where an axis shakes above 37.5 Hz more
// than twice as much as noise at the level of the octave below would, all axes are low-passed, without delay,
// up to 25 Hz and sampled anew at 75 Hz; where one shakes so between 18.75 and 37.5 Hz, up to 12.5 Hz and
// sampled at 37.5 Hz, at which what is left is nearly white. A joint solve that weighs samples by their
// scatter would take such vibration for noise of slow signals, which it is not. So it would turning that no
// spline follows: where the rates have in the octave above half of the finest knots' rate more than twice the
// noise that any usual gyroscope has there and that their level beyond would make, they are low-passed up to
// there, behind the one or the other filter. Samples come in order of time; lost ones are bridged. At the
// ends half of the filter's width (0.13 or 0.26 s) is left out, about gaps as much of it as the vibration
// that is missing in them needs (16 ms and more, or 32). nullopt where nothing is to be taken away, where
// samples come too seldom to show it, or where gaps would leave too little.
std::optional<FilteredImu> WithoutVibration(const std::vector<ImuSample>& samples);

}  // namespace mlic
