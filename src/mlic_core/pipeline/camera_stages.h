#pragma once

#include <string>
#include <vector>

#include "mlic_core/camera/tracks/tracks_from_images.h"
#include "mlic_core/initialization/camera_on_trajectory.h"
#include "mlic_core/pipeline/stage_clock.h"

namespace mlic {

// Keyframes and features of every drive's images. state: its trajectories say where the vehicle moves;
// without drives keyframes are chosen by time alone.
std::vector<ImageFeatures> FeatureStage(const StageContext& context, const std::vector<CameraStart>& start,
                                        const CalibrationState& state);

// Tracks of each camera by itself, before any camera's pose is known.
std::vector<TrackSet> TrackStage(const StageContext& context, const std::vector<CameraStart>& start,
                                 const std::vector<ImageFeatures>& features);

// Cameras found from their own tracks are decimetres from each other, which misleads the search for matches
// of near places across cameras. So that is done twice: a first look at every second keyframe brings them
// together to millimetres.
enum class SharedPass { kFirstLook, kAll };

// Tracks again, now that the cameras of the state say which images share their view: across cameras and
// across time.
std::vector<TrackSet> SharedTrackStage(const StageContext& context, SharedPass pass,
                                       const CalibrationState& state,
                                       const std::vector<ImageFeatures>& features);

// Intrinsics from COLMAP for these of the cameras that the rig file gives only a field of view of, from the
// drive that shows each camera most. A camera on which COLMAP fails keeps its start, and a line says why;
// where there is no COLMAP, all do, and a warning says what to install. Returns whether a camera starts from
// COLMAP now.
bool ColmapStage(const StageContext& context, const std::vector<bool>& asked,
                 const std::vector<TrackSet>& tracks, std::vector<CameraStart>* start);

// Cameras (docs/method.md, section 7.5) on the state's trajectories. file: under which the stage is kept.
CameraInitialization CameraInitializationStage(const StageContext& context, const std::string& file,
                                               const std::vector<CameraStart>& start,
                                               const std::vector<TrackSet>& tracks,
                                               const CalibrationState& state);

// The cameras found again on the same trajectories, with the tracks across cameras and time: the joint
// adjustment judges each observation by cameras that agree with all of them. Says so in `found`.
void SharedCameraStage(const StageContext& context, SharedPass pass, const std::vector<CameraStart>& start,
                       const std::vector<TrackSet>& shared_tracks, const CalibrationState& state,
                       CameraInitialization* found);

}  // namespace mlic
