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
};

// Where an axis has more than twice the noise above three times the band of the finest knots (kFinestKnots)
// than just above that band, all axes are low-passed, without delay, and sampled anew at eight times the band
// (100 Hz). A joint solve that weighs samples by their scatter would take such vibration for noise of slow
// signals, which it is not. Samples come in order of time; lost ones are bridged, at gaps and ends half of
// the filter's width (0.13 s) is left out. nullopt where there is none, where samples come too seldom to show
// it, or where gaps would leave too little.
std::optional<FilteredImu> WithoutVibration(const std::vector<ImuSample>& samples);

}  // namespace mlic
