#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// What all ranges of a LiDAR err by (RangeCorrection). It is hardly told from the LiDAR's place where the
// view is narrow, and most LiDARs have less of it than the data show, so it is no parameter of every solve:
// it is found beside one, everything else following.
struct RangeErrors {
  std::vector<RangeCorrection> steps;  // of each LiDAR, to add to the state's
  // Of offset and slope of each LiDAR in turn, for white residuals of variance one; zero of those held.
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd coupling;  // calibration x these: the information that both share
};

// Which of them are found; the others stay.
struct FreeRanges {
  bool offset = false;
  bool slope = false;
};

// At a solution of the problem; free: of each LiDAR. Nothing where the equations have no solution, the
// trajectory is held or none is free. docs/method.md, section 4.
std::optional<RangeErrors> MeasureRangeErrors(const JointProblem& problem, const CalibrationState& state,
                                              const std::vector<FreeRanges>& free);

// What is free of LiDARs whose ranges the state corrects, or those of single rings: their common errors look
// like the LiDAR's place, and are found with it.
std::vector<FreeRanges> CorrectedRanges(const CalibrationState& state);

// Corrects the ranges of LiDARs whose offset differs from zero by four of its sigmas, or that were corrected
// before. correlation: of the residuals (CorrelationFactor). True if it changed any by a tenth of a sigma.
bool CorrectRanges(const JointProblem& problem, double correlation, CalibrationState* state);

}  // namespace mlic
