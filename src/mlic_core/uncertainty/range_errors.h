#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// What all ranges of a LiDAR err by (RangeCorrection). It is hardly told from the LiDAR's place where the
// view is narrow, and most LiDARs have less of it than the data show, so it is no parameter of every solve:
// it is found beside one, everything else following.
struct RangeErrors {
  std::vector<Eigen::Vector3d> steps;  // of each LiDAR, to add
  // Of the three of each LiDAR in turn, for white residuals of variance one; zero of those held.
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd coupling;  // calibration x these: the information that both share
};

// What the three parameters of a LiDAR are. Level planes, nearer to the horizontal than to the vertical, have
// one of their own: ground is rough, and what its bumps hide looks like an error of ranges.
enum class RangeModel {
  kOffsetAndSlope,  // RangeCorrection: m, m/rad; m of points on level planes besides
  kBySurface,  // m: of points that meet other planes at less than 45 deg; of the rest of these; of level ones
};

using FreeRanges = std::array<bool, 3>;  // which of the three are found; the others stay

// At a solution of the problem; free: of each LiDAR. Nothing where the equations have no solution, the
// trajectory is held or none is free. docs/method.md, section 4.
std::optional<RangeErrors> MeasureRangeErrors(const JointProblem& problem, const CalibrationState& state,
                                              RangeModel model, const std::vector<FreeRanges>& free);

// Whether the state corrects the ranges of any LiDAR.
bool AnyRangeCorrected(const CalibrationState& state);

// Corrects the ranges of LiDARs whose offset is confirmed, now or before: points on planes that are not level
// show more than three of its sigmas, and those that meet these planes steeply and the rest each predict the
// other better than no offset does. What depends on the incidence (wide beams, returns of foliage) is no
// error of ranges. correlation: of the residuals (CorrelationFactor). True if it changed any by a tenth of a
// sigma.
bool CorrectRanges(const JointProblem& problem, double correlation, CalibrationState* state);

// What adds to the scatter of the gradient (ScatterOfPoints): the corrections' own errors, and what points on
// level planes err by beyond three sigmas, which is no error of ranges and stays in: the calibration is as
// unsure as it would move without. Zero where none is corrected and none errs so. correlation: as above.
Eigen::MatrixXd ScatterOfRanges(const JointProblem& problem, const CalibrationState& state,
                                double correlation);

}  // namespace mlic
