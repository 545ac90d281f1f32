#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "mlic_core/association/landmark_options.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// Observations of a landmark that count as known before it is seen, in degrees of freedom: few observations
// say little about its own noise.
constexpr double kPriorFreedom = 1.0;  // from: measured, paper rig, seeds 1 and 3, against 4
// How much its observations say about it.
inline double LandmarkFreedom(std::size_t observations) {
  return std::max(1.0, 2.0 * static_cast<double>(observations) - 3.0);
}

// By how much larger the sigmas of a landmark's observations are, where its noise is its own, for being many:
// what the piece of surface looks like from all of its views (a reveal that is seen from below only, an edge
// that shade moves) does not average out, so a landmark counts for a dozen observations at most.
inline double ManyObservationsScale(std::size_t observations) {
  constexpr double kMostObservations = 12.0;  // from: measured, paper rig, seeds 1 to 3, against 5, 8 and 14
  return std::sqrt(std::max(1.0, static_cast<double>(observations) / kMostObservations));
}

// A camera whose observations spread by more, of what the tracks claim, does not follow its lens model, its
// shutter or its trajectory. from: measured, 0.3 to 1.5 on 40 right cameras (simulated and KITTI), 3.8
// and 8.7 on two wrong ones
constexpr double kLargestSpread = 3.0;

// By how much each camera's reprojection errors exceed the tracks' own sigmas (robust; spread at least
// `least`), given the options with which the landmarks were made. The dependence is what neighbouring
// observations of a landmark have in common. A camera without observations: `least`.
std::vector<LandmarkNoise> MeasureLandmarkNoise(const std::vector<DriveTerms>& drives,
                                                const CalibrationState& state,
                                                const LandmarkOptions& made_with, double least = 0.3);

}  // namespace mlic
