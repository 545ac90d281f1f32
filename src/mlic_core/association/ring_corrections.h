#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mlic_core/association/ring_sums.h"
#include "mlic_core/crossmodal/intensity_map.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// The point as its ring's correction has it. Elevation is measured from the plane across the LiDAR's z axis.
Eigen::Vector3f CorrectedPoint(const Eigen::Vector3f& position, const RingCorrection& correction);

// Powers of ten by which an echo is stronger than the usual one of its LiDAR, at most two either way; 0 where
// the LiDAR reports no intensities.
double DecadesOfStrength(float intensity, double reference);

// The point of one of the state's LiDARs, its ring's and all ranges' corrections applied.
Eigen::Vector3f CorrectedPoint(const LidarPoint& point, const CalibrationState& state, std::size_t lidar);

// The same for drawing maps; nothing where no LiDAR has any. The state must outlive it.
PointCorrection CorrectionOfRings(const CalibrationState& state);

// What corrections of rings at these elevations (rad) leave alone, as extrinsics look like it: a mean, and a
// slope over the elevation. Columns are orthonormal.
Eigen::MatrixX2d RingTrend(const Eigen::VectorXd& elevations);

// What the lasers of a LiDAR err by, each for itself: a range too long, an elevation too high. No number of
// points averages it out. Found from the residuals of each ring's points to the planes of all, as far as
// rings err more widely than the residuals' noise, what neighbours share (ring_errors.h) and how quarters of
// the points (of the drive and of the view) differ account for; in elevation where that is so with ranges
// corrected, or what a ring's ground differs from its walls by would look like errors of both. Their trend is
// not corrected (RingTrend). Corrections are cross-validated: those from the first half of the
// drive must lower the squared residuals of the second and the other way round, and those of the left half of
// the view the right's. They are judged as a whole each time, those that are no longer confirmed taken back.
// LiDARs of fewer than 8 rings, or whose points carry none, have no corrections. correlation: of the
// residuals (CorrelationFactor). Corrects those of the state that move by half of their
// sigmas; true if any LiDAR's do.
bool CorrectRings(const std::vector<DriveTerms>& drives, double correlation, CalibrationState* state);

// What the rings of each LiDAR may err by beyond their corrections, those without any and those with few
// points included: the mean of the errors' products, ranges (m) of all rings by their numbers, then
// elevations (rad). Zero for LiDARs of fewer than 8 rings.
std::vector<Eigen::MatrixXd> DoubtOfRings(const std::vector<DriveTerms>& drives, double correlation,
                                          const CalibrationState& state);

// Root mean square over the rings that were corrected: m, rad; zero for none.
RingCorrection TypicalCorrection(const RingCorrections& corrections);

// For people, to go on from a LiDAR's name; empty when nothing is corrected.
std::string DescribeCorrections(const CalibrationState& state, std::size_t lidar);

}  // namespace mlic
