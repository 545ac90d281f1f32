#pragma once

#include <cstddef>
#include <vector>

#include "mlic_core/association/landmark_options.h"
#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// One drive's tracks as point landmarks, triangulated with the cameras as they stand in the state; what does
// not agree is left out. Sigmas of the observations: those of the tracks times the camera's noise.
LandmarkSet TriangulateLandmarks(const TrackSet& tracks, const CalibrationState& state, std::size_t drive,
                                 const LandmarkOptions& options);

// The tracks without what cameras that were not found saw.
std::vector<TrackSet> WithoutLostCameras(std::vector<TrackSet> tracks, const std::vector<bool>& found);

// Observations of each camera in all drives.
std::vector<std::size_t> CountObservations(const std::vector<LandmarkSet>& landmarks, std::size_t cameras);

}  // namespace mlic
