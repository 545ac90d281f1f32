#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mlic_core/geometry/plane.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// What is found of a LiDAR's ranges. Level planes, nearer to the horizontal than to the vertical, have an
// offset of their own: ground is rough, and what its bumps hide looks like an error of ranges.
enum RangeParameter {
  kRangeOffset,  // m
  kRangeSlope,   // m/rad
  kRangeWalk,    // m for each power of ten
  kRangeLevel,   // m, of points on level planes besides
  kRangeParameters
};

// The parameters may stand for parts of the points, which tell whether these err alike.
enum class RangeModel {
  kWhole,
  kByIncidence,  // offset: of points that meet planes, not level ones, at less than 45 deg; slope: of the
                 // rest
  // The walk, and in the slope's place that of the rest:
  kByStrength,  // of stronger echoes than the usual one
  kByRange,     // of points nearer than the usual one
  kByLevel,     // of points on level planes
};

// How far planes' relief goes with their brightness, m for each power of ten: of those that are not level,
// and of level ones. from: structural
constexpr int kReliefs = 4;

// By what a point's range may grow: every model's parameters are sums of these.
enum RangeColumn {
  kOne,  // of points on planes
  kElevation,
  kStrength,
  kOnLevel,
  kSteep,  // on planes that are not level: of points that meet them at less than 45 deg, and of the rest
  kOblique,
  kStrengthOfStrong,  // of stronger echoes than the usual one, of nearer points, of points on level planes
  kStrengthOfNear,
  kStrengthOfLevel,
  kOneOfSeen,  // of points of the map that a camera sees: how strong their echoes were is not known
  kElevationOfSeen,
  kRangeColumns
};

// Beside the calibration's: `of_lidar` of each LiDAR, then the reliefs.
inline Eigen::Index WithReliefs(std::size_t lidars, int of_lidar) {
  return static_cast<Eigen::Index>(lidars) * of_lidar + kReliefs;
}

// Where a LiDAR's column stands behind the calibration.
inline Eigen::Index ColumnOf(std::size_t lidar, int column) {
  return static_cast<Eigen::Index>(lidar) * kRangeColumns + column;
}

// How a model's parameters are made of the columns.
Eigen::Matrix<double, kRangeColumns, kRangeParameters> ColumnsOf(RangeModel model);

// The intensity of which half of a LiDAR's echoes are stronger, or what its correction is about.
std::vector<double> UsualIntensities(const JointProblem& problem, const CalibrationState& state);

// By what the range of a point on a plane grows with its LiDAR's columns and the reliefs.
class RangeRow {
 public:
  static constexpr int kSize = kRangeColumns + kReliefs;  // from: structural
  using Vector = Eigen::Matrix<double, kSize, 1>;

  // references: UsualIntensities; must outlive this.
  RangeRow(const JointProblem& problem, const std::vector<double>& references);

  Vector Of(const PlaneObservation& o, const Plane& plane) const;

 private:
  const std::vector<double>& references_;
  std::vector<double> relative_strengths_, usual_ranges_;
};

}  // namespace mlic
