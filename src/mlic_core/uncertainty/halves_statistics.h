#pragma once

#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// What deviations and largest differences of all these sensors exceed by chance in 3 of 1000 calibrations
// whose sigmas are as good as ours.
double LargestByChance(const std::vector<SensorHalves>& sensors);

// By what factor sigmas of a quantity are larger than claimed, as its parts differ: the claim counts as if it
// came from 20 squares, to which the differences add theirs. Never less than one.
double GrowthOfSigmas(const HalvesDifference& difference);

// The largest of a sensor's deviations and differences of single parameters, sigmas.
double WorstOf(const SensorHalves& sensor);

}  // namespace mlic
