#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// What COLMAP is to work on: one camera. Choose few keyframes with parallax between them, and intrinsics from
// the field of view: from COLMAP's own default it registers few images with a wrong focal length.
struct ColmapInput {
  CameraIntrinsics start;
  std::vector<std::vector<Eigen::Vector2f>> keypoints;  // of each keyframe; pixel centres at integers
  std::vector<PairMatches> matches;                     // verified; indices into keypoints
  std::vector<int> keyframes;  // index of each keyframe in the TrackSet it came from; may be empty
  std::string folder;          // where its files go when it is one of several; empty: its number
};

// One camera's keyframes of a TrackSet; every pair of keyframes of a track is matched.
ColmapInput ColmapInputFromTracks(const TrackSet& tracks, int camera, const CameraIntrinsics& start);

struct ColmapOptions {
  std::string program = "colmap";
  // from: definition, docs/cameras.md.
  double least_registered_share = 0.25;  // a drive that breaks into parts still shows the camera
  double largest_rms = 2.0;              // px; from: definition, docs/cameras.md
  // from: definition, docs/cameras.md.
  double least_coverage = 0.25;  // share of the image's cells with observations
};

// The largest model that COLMAP made. Scale and frame are COLMAP's own.
struct ColmapModel {
  CameraIntrinsics intrinsics;                                // of the input's model
  std::vector<std::optional<RigidTransform>> T_world_camera;  // for each keyframe; nothing: not registered
  std::vector<Eigen::Vector3d> points;
  std::vector<TrackObservation> observations;  // of the points, by keyframe (of the input)
  std::vector<int> observed_points;            // of each observation
  double registered_share = 0.0;
  double reprojection_rms = 0.0;      // px, of both coordinates together
  double coverage = 0.0;              // share of 8 x 8 cells of the image with observations
  std::vector<std::string> problems;  // checks that failed, each one line; empty: to be trusted
};

struct ColmapOutcome {
  std::optional<ColmapModel> model;
  std::string problem;    // where there is no model: why, and what to do, one line
  bool installed = true;  // false: there is no such program
};

// Told how far the work is, 0 to 1, now and then and from any thread.
using ColmapProgress = std::function<void(double)>;

// Runs COLMAP's mapper without a display, on one processor: same input, same output. directory: for the
// database, model and colmap.log; what is in it is replaced. Throws Cancelled (COLMAP is killed), InputError
// where the directory cannot be written.
ColmapOutcome RunColmap(const ColmapInput& input, const ColmapOptions& options,
                        const std::filesystem::path& directory, const CancellationToken& cancellation,
                        const ColmapProgress& progress = {});

// Several cameras at once, each in its folder of the directory.
std::vector<ColmapOutcome> RunColmap(const std::vector<ColmapInput>& inputs, const ColmapOptions& options,
                                     const std::filesystem::path& directory,
                                     const CancellationToken& cancellation,
                                     const ColmapProgress& progress = {});

}  // namespace mlic
