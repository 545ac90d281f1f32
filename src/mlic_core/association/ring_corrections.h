#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mlic_core/crossmodal/intensity_map.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// The point as its ring's correction has it. Elevation is measured from the plane across the LiDAR's z axis.
Eigen::Vector3f CorrectedPoint(const Eigen::Vector3f& position, const RingCorrection& correction);

// Above the plane across the LiDAR's z axis: rad.
double ElevationOf(const Eigen::Vector3f& position);

// The point of one of the state's LiDARs, its ring's and all ranges' corrections applied.
Eigen::Vector3f CorrectedPoint(const LidarPoint& point, const CalibrationState& state, std::size_t lidar);

// The same for drawing maps; nothing where no LiDAR has any. The state must outlive it.
PointCorrection CorrectionOfRings(const CalibrationState& state);

// By how much a point's residual (along the beam) grows when its ring's range and elevation do: m per m, m
// per rad. The point lies within the trajectory.
Eigen::Vector2d RingJacobian(const PlaneObservation& point, const MapPlane& plane,
                             const SensorCalibration& lidar, const SplitSpline& trajectory);

// What corrections of rings at these elevations (rad) leave alone, as extrinsics look like it: a mean, and a
// slope over the elevation. Columns are orthonormal.
Eigen::MatrixX2d RingTrend(const Eigen::VectorXd& elevations);

// What the lasers of a LiDAR err by, each for itself: a range too long, an elevation too high. No number of
// points averages it out. Found from the residuals of each ring's points to the planes of all. Their
// trend is not corrected (RingTrend). Corrections are cross-validated, as what rings share in error with
// their map or with extrinsics on their way looks the same (docs/method.md, section 4): those from the first
// half of the drive must be nearer to those from the second than no corrections are, and the other way round;
// and those of the left half of the view to the right's; and so must what each ring asks for beyond its
// neighbours, as what depends on the incidence (wide beams on the ground) goes smoothly over the rings.
// Ranges and elevations are judged apart. Later rounds may add what all halves agree on. LiDARs of fewer than
// 8 rings, or whose points carry none, have no corrections. Improves those of the state; true if it changed
// any.
bool CorrectRings(const std::vector<DriveTerms>& drives, CalibrationState* state);

// Root mean square over the rings that were corrected: m, rad; zero for none.
RingCorrection TypicalCorrection(const RingCorrections& corrections);

// For people, to go on from a LiDAR's name; empty when nothing is corrected.
std::string DescribeCorrections(const CalibrationState& state, std::size_t lidar);

}  // namespace mlic
