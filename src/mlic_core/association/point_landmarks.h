#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/problem/joint_problem.h"

namespace mlic {

// The noise of one camera's observations, of what the tracks claim (the calibration's own errors come on top
// while it is far from right).
struct LandmarkNoise {
  double spread = 1.0;  // of single observations, outliers aside: what a observation is judged by
  double dependence =
      1.0;  // observations that share errors count for less: their sigmas are that much larger
};

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

struct LandmarkOptions {
  std::vector<LandmarkNoise> noise;  // of each camera; empty: as the tracks claim
  double least_sigma = 0.0;          // px; no observation counts for better; from: structural
  double largest_error = 4.0;        // sigmas; from: derivation, 1 of 3000 observations lies beyond
  double least_parallax_deg = 0.5;
  // Each landmark's noise is its own: corners at steps of depth, reflections and moving shadows look unlike
  // themselves from elsewhere, and their observations agree less than those of a mark on a road. Only once
  // the calibration is nearly right: before, landmarks that say much about it disagree the most.
  bool noise_of_each = false;
  std::size_t most_points = 30000;  // in one drive; the longest tracks are kept; from: guard, memory
};

// One drive's tracks as point landmarks, triangulated with the cameras as they stand in the state; what does
// not agree is left out. Sigmas of the observations: those of the tracks times the camera's noise.
LandmarkSet TriangulateLandmarks(const TrackSet& tracks, const CalibrationState& state, std::size_t drive,
                                 const LandmarkOptions& options);

// The same for all drives.
std::vector<LandmarkSet> TriangulateLandmarks(const std::vector<TrackSet>& tracks,
                                              const CalibrationState& state, const LandmarkOptions& options);

// The tracks without what cameras that were not found saw.
std::vector<TrackSet> WithoutLostCameras(std::vector<TrackSet> tracks, const std::vector<bool>& found);

// By how much each camera's reprojection errors exceed the tracks' own sigmas (robust; spread at least
// `least`), given the options with which the landmarks were made. The dependence is what neighbouring
// observations of a landmark have in common. A camera without observations: `least`.
std::vector<LandmarkNoise> MeasureLandmarkNoise(const std::vector<LandmarkSet>& landmarks,
                                                const CalibrationState& state,
                                                const LandmarkOptions& made_with, double least = 0.3);

// Observations of each camera in all drives.
std::vector<std::size_t> CountObservations(const std::vector<LandmarkSet>& landmarks, std::size_t cameras);

}  // namespace mlic
