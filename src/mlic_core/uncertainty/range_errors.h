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
  std::vector<Eigen::Vector2d> steps;  // of each LiDAR, to add
  // Of the two of each LiDAR in turn, for white residuals of variance one; zero of those held.
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd coupling;  // calibration x these: the information that both share
};

// What the two parameters of a LiDAR are.
enum class RangeModel {
  kOffsetAndSlope,  // RangeCorrection: m, m/rad
  kByIncidence,  // m: an offset of points on planes that they meet at less than 45 deg, and one of the rest
};

using FreeRanges = std::array<bool, 2>;  // which of the two are found; the others stay

// At a solution of the problem; free: of each LiDAR. Nothing where the equations have no solution, the
// trajectory is held or none is free. docs/method.md, section 4.
std::optional<RangeErrors> MeasureRangeErrors(const JointProblem& problem, const CalibrationState& state,
                                              RangeModel model, const std::vector<FreeRanges>& free);

// Offsets of LiDARs whose ranges the state corrects, and slopes where it corrects their rings too.
std::vector<FreeRanges> CorrectedRanges(const CalibrationState& state);

// Corrects the ranges of LiDARs whose offset is confirmed, now or before: points that meet planes steeply and
// the rest, each for themselves, show more than four of its sigmas, and each predicts the other better than
// no offset does. What depends on the incidence (rough ground, wide beams, returns of foliage) is no error of
// ranges. correlation: of the residuals (CorrelationFactor). True if it changed any by a tenth of a sigma.
bool CorrectRanges(const JointProblem& problem, double correlation, CalibrationState* state);

}  // namespace mlic
