#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mlic_core/crossmodal/intensity_map.h"
#include "mlic_core/problem/joint_problem.h"

namespace mlic {

// The point as its ring's correction has it. Elevation is measured from the plane across the LiDAR's z axis.
Eigen::Vector3f CorrectedPoint(const Eigen::Vector3f& position, const RingCorrection& correction);

// The same for a point of one of the state's LiDARs; where the state has no correction, as measured.
Eigen::Vector3f CorrectedPoint(const LidarPoint& point, const CalibrationState& state, std::size_t lidar);

// The same for drawing maps; nothing where no LiDAR has corrections. The state must outlive it.
PointCorrection CorrectionOfRings(const CalibrationState& state);

// What the lasers of a LiDAR err by, each for itself: a range too long, an elevation too high. An HDL-64E's
// rings are off by 22 mm and 0.05 deg (rms), which is several times what single points scatter by on near
// ground, and which no number of points averages out. Found from the residuals of each ring's points to the
// planes of all. The rings' mean range and the mean and slope of their elevations are left alone: height,
// pitch and range scale could look like them.
// Only what is beyond doubt the sensor's: corrections from the first half of the drive must take a fifth of
// the points' variance away in the second, and the other way round; and those of the left half of the view
// in the right. What rings share in error with their map, or with extrinsics that are not yet right, fails
// at that by far: simulated sensors, whose rings are right, explain less than nothing (0 to -6 percent),
// an HDL-64E 34 percent each way. What later rounds add counts as long as it, too, takes something away in
// every other half. LiDARs of fewer than 8 rings, or whose points carry none, have no corrections. Improves
// those of the state; true if it changed any.
bool CorrectRings(const std::vector<PlaneAssociation>& associations, CalibrationState* state);

// Root mean square over the rings that were corrected: m, rad; zero for none.
RingCorrection TypicalCorrection(const RingCorrections& corrections);

// For people, to go on from a LiDAR's name; empty when nothing is corrected.
std::string DescribeCorrections(const RingCorrections& corrections);

}  // namespace mlic
