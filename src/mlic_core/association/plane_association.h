#pragma once

#include <vector>

#include "mlic_core/lidar/plane_map.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

struct AssociationOptions {
  double root_voxel = 2.0;  // m; from: structural, replaced by RootVoxelSize's
  // from: structural, replaced by that of the round.
  std::size_t points_per_scan = 2500;      // that take part, evenly over the scan
  std::vector<bool> lidars;                // which take part; empty: all
  std::vector<std::uint64_t> last_voxels;  // of the map before (PlaneMapOptions)
};

// The size of root voxels, m, that suits what a drive's LiDARs see: a hundredth of what they see far, between
// one and two metres, as halls have shelves and yards have facades.
double RootVoxelSize(const Drive& drive);

// Draws the map of one drive with the current state and ties points to its planes (docs/method.md, section
// 4). A place that is seen for longer than kLongestCoupling (time_windows.h) comes as one plane for each such
// stretch of time, in order of time.
PlaneAssociation AssociatePlanes(const Drive& drive, const CalibrationState& state, std::size_t drive_index,
                                 const std::vector<PlaneNoise>& noise, const AssociationOptions& options);

// Noise of each LiDAR from the residuals of its points: robust variances over the incidence, fitted by
// range^2 * cos^2 + floor^2. A LiDAR with too few points keeps its noise. Never falls below a fifth of the
// last noise at once, so that one lucky map does not shut the gate.
std::vector<PlaneNoise> MeasurePlaneNoise(const std::vector<DriveTerms>& drives,
                                          const CalibrationState& state, const std::vector<PlaneNoise>& last);

}  // namespace mlic
