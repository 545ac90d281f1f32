#pragma once

#include <map>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// How well one time offset serves all scans of a LiDAR, or all images of a camera. Stamps that a host gives
// on arrival jitter, clocks drift and jump: then single scans disagree with the trajectory by more than their
// residuals' noise, each by a time of its own. docs/method.md, section 11.
struct StampErrors {
  // By how much the scans' own time errors scatter more than their noise allows, one by one or over a few
  // seconds together: the mean of (error / its sigma)^2, never less than one. The calibration's variances are
  // too small by about that.
  double excess = 1.0;
  double jitter = 0.0;   // s, what is left of the scatter of single scans when their noise is taken out
  bool wanders = false;  // not single scans are off, but seconds of them: the clock drifts or jumps
};

// Of every LiDAR, then of every camera. The time error of a scan is the Gauss-Newton step in its time alone,
// from the residuals of its points (or an image's landmarks) and their derivatives to the time offset:
//   error = -sum(J r / sigma^2) / sum(J^2 / sigma^2),   its sigma = sum(J^2 / sigma^2)^-1/2.
// A trajectory that follows the errors hides a part of them; the IMU lets it follow slow ones least.
std::vector<StampErrors> MeasureStampErrors(const JointProblem& problem, const CalibrationState& state);

// What one scan or image says of its own time: the gradient and the information of an error of it.
struct ScanSum {
  double gradient = 0.0;
  double information = 0.0;
};
// By the scan's time, sensor clock.
using ScanSums = std::map<double, ScanSum>;

// Of each drive, of each LiDAR, then of each camera. MeasureStampErrors in two steps, for a drive that was
// calibrated in parts.
using StampSums = std::vector<std::vector<ScanSums>>;
StampSums SumStampErrors(const JointProblem& problem, const CalibrationState& state);
std::vector<StampErrors> JudgeStampErrors(const StampSums& drives);

}  // namespace mlic
