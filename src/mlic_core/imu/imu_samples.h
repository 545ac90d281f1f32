#pragma once

#include <vector>

#include "mlic_core/sensors/measurements.h"

namespace mlic {

// The samples with finite values and strictly increasing times; the others are left out. Throws InputError if
// fewer than 4 remain.
std::vector<ImuSample> OrderedFiniteSamples(const std::vector<ImuSample>& samples);

// The longest time between two neighbours that interpolation may bridge: four periods, and at least 30 ms.
// What is longer is a gap.
double LongestBridgedPeriod(double median_period);

}  // namespace mlic
