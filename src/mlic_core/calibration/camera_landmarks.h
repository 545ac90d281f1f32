#pragma once

#include <vector>

#include "mlic_core/calibration/joint_problem.h"
#include "mlic_core/camera/tracks.h"

namespace mlic {

struct LandmarkOptions {
  // By how much larger than the tracks say the noise of each camera's pixels is taken to be (the
  // calibration's own errors come on top while it is far from right). Empty: 1 for all.
  std::vector<double> noise_scale;
  double least_sigma = 0.0;    // px; no observation counts for better
  double largest_error = 4.0;  // of an observation that takes part, in its sigmas
  double least_parallax_deg = 0.5;
  std::size_t most_points = 30000;  // in one drive; the longest tracks are kept
};

// One drive's tracks as point landmarks, triangulated with the cameras as they stand in the state; what does
// not agree is left out. Sigmas of the observations: those of the tracks times the noise scale.
LandmarkSet TriangulateLandmarks(const TrackSet& tracks, const CalibrationState& state, std::size_t drive,
                                 const LandmarkOptions& options);

// The same for all drives.
std::vector<LandmarkSet> TriangulateLandmarks(const std::vector<TrackSet>& tracks,
                                              const CalibrationState& state, const LandmarkOptions& options);

// The tracks without what cameras that were not found saw.
std::vector<TrackSet> WithoutLostCameras(std::vector<TrackSet> tracks, const std::vector<bool>& found);

// For each camera the factor by which its reprojection errors exceed the tracks' own sigmas (robust, at least
// `least`), given the noise scale with which the landmarks were made. What neighbouring sights of a landmark
// have in common makes it larger than the spread alone. A camera without observations: `least`.
std::vector<double> MeasureLandmarkNoise(const std::vector<LandmarkSet>& landmarks,
                                         const CalibrationState& state, const LandmarkOptions& made_with,
                                         double least = 0.3);

// Observations of each camera in all drives.
std::vector<std::size_t> CountObservations(const std::vector<LandmarkSet>& landmarks, std::size_t cameras);

}  // namespace mlic
