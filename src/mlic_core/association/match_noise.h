#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// What one camera's matches with the map err by beyond what each claims.
struct MatchNoise {
  // Of the claimed sigmas: matches of one part of a photo share what is wrong with the map and the rendering
  // there, so that many are little better than one.
  double scale = 1.0;
  // Standard deviations of what all matches of one photo share: light and shade, and, along the motion of the
  // image, what moved while it was exposed.
  double shift = 0.0;  // px
  double smear = 0.0;  // s
};

// Adds a point of one set that a LiDAR measured, with its only observation, to another.
void AddMatch(const LandmarkSet& from, std::size_t point, LandmarkSet* to);

// The points that a LiDAR measured.
LandmarkSet PointsOnMap(const LandmarkSet& landmarks);

// One drive's points, those on the map where the LiDARs that measured them have them at a state.
LandmarkSet PlacedByLidars(LandmarkSet matches, const CalibrationState& state, std::size_t drive);

// Of each camera, at a solved state whose matches were weakened by `made_with` (of each camera). From the
// mean errors of the blocks of photos against those of independent matches, and of photos against those of
// independent blocks, the latter by restricted maximum likelihood: what the camera's pose, offset, focal
// lengths and centre are off by at the state is not taken for noise. A camera without matches: as it was.
std::vector<MatchNoise> MeasureMatchNoise(const std::vector<DriveTerms>& drives,
                                          const CalibrationState& state,
                                          const std::vector<MatchNoise>& made_with);

// Makes the sigmas of one drive's matches larger by what the matches of a photo share: so much that the mean
// of all matches of a photo is as unsure as that.
void WeakenMatches(const std::vector<MatchNoise>& noise, const CalibrationState& state, std::size_t drive,
                   LandmarkSet* matches);

// What follows a camera's name in the log.
std::string DescribeMatchNoise(const MatchNoise& noise);

}  // namespace mlic
