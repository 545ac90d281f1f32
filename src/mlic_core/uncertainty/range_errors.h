#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
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
using RangeVector = Eigen::Matrix<double, kRangeParameters, 1>;
using FreeRanges = std::array<bool, kRangeParameters>;  // which of them are found; the others stay

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

// What all ranges of LiDARs err by (RangeCorrection). It is hardly told from a LiDAR's place where the view
// is narrow, and most LiDARs have less of it than the data show, so it is no parameter of every solve: it is
// found beside one, everything else following.
struct RangeErrors {
  std::vector<RangeVector> steps;  // of each LiDAR, to add
  std::vector<double> references;  // of each LiDAR, what its walk is about (RangeCorrection)
  // Of the parameters of each LiDAR in turn, for white residuals of variance one; zero of those held.
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd coupling;  // calibration x these: the information that both share

  // Where a LiDAR's parameter stands among those of all.
  static Eigen::Index Of(std::size_t lidar, RangeParameter parameter) {
    return static_cast<Eigen::Index>(kRangeParameters * lidar) + parameter;
  }

  // Of a LiDAR's parameter. correlation: by which residuals that share errors widen variances.
  double Sigma(std::size_t lidar, RangeParameter parameter, double correlation) const {
    return std::sqrt(correlation * covariance(Of(lidar, parameter), Of(lidar, parameter)));
  }
};

// At a solution of the problem; free: of each LiDAR. Where any walk is free, planes have a relief that their
// brightness goes with, which all LiDARs see: dark windows lie deeper in a wall. Nothing where the equations
// have no solution, the trajectory is held or none is free. docs/method.md, section 4.
std::optional<RangeErrors> MeasureRangeErrors(const JointProblem& problem, const CalibrationState& state,
                                              RangeModel model, const std::vector<FreeRanges>& free);

// With the same parameters free of all LiDARs.
std::optional<RangeErrors> MeasureRangeErrorsOfAll(const JointProblem& problem, const CalibrationState& state,
                                                   RangeModel model, const FreeRanges& free);

}  // namespace mlic
