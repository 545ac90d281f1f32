#pragma once

#include <string>
#include <vector>

#include "mlic_core/association/match_noise.h"
#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

struct MapMatchingOptions {
  // A map is made of so many seconds of scans and matched to photos of the same time only: what a camera sees
  // is then tied to LiDARs at nearly the same time, whatever the trajectory drifts by in between.
  double window = 12.0;    // s
  std::size_t views = 20;  // of each camera in all drives, spread over the windows; from: guard, time
  std::size_t map_points = 3000000;  // returns that one window's map is made of; from: guard, time and memory
  double sigma_along = 5e-3;         // m, of a place of the map along its beam
  double sigma_across = 3e-3;        // m
  const FeatureMatcher* features = nullptr;  // what finds the map in photos; null: its structure
  std::vector<MatchNoise> noise;             // of each camera: its scale counts; empty: as claimed
  // from: guard, cameras that see the map have hundreds (kitti_0005: 306).
  int fewest_matches = 30;  // of a camera; with fewer it has none
};

// Places of the LiDAR map found in photos (docs/method.md, section 9).
struct MapMatches {
  std::vector<LandmarkSet>
      landmarks;  // of each drive: each point has one observation of a LiDAR and one of a camera
  // Of each camera:
  std::vector<std::size_t> counts;   // matches that agree with one pose
  std::vector<double> inlier_share;  // of all matches
  std::vector<double> nid;           // mean normalised information distance of photos and renderings
};

// What is known of the state's sensors beside their calibration.
struct MatchedCameras {
  const std::vector<TrackSet>& tracks;       // of each drive: their keyframes are the photos to choose from
  const std::vector<PoseSigma>& sigmas;      // of each camera against the LiDARs, now: they size the search
  const std::vector<bool>& found;            // of each camera: others are left out
  const std::vector<bool>& rejected_lidars;  // of each LiDAR: the map is made without it
};

// Renders the map of each window into each camera's most telling photos and matches them, at full resolution
// or, where that gives few matches, at a coarser one; a robust pose of each camera sorts out what does not
// agree.
MapMatches MatchCamerasToMap(const Dataset& dataset, const CalibrationState& state,
                             const MatchedCameras& cameras, const MapMatchingOptions& options,
                             const Monitor& monitor);

// Adds the points of one set to another.
void Append(const LandmarkSet& more, LandmarkSet* landmarks);

}  // namespace mlic
