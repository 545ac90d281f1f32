#pragma once

#include <string>
#include <vector>

#include "mlic_core/evaluation/truth_comparison.h"
#include "mlic_core/result/result.h"

namespace mlic {

// An intrinsic parameter that two calibrations of one camera differ in: a minus b, in the parameter's unit
// (px, s for the readout, none for distortion). sigma: of the difference; 0 where neither claims one.
struct IntrinsicDifference {
  std::string camera;
  std::string parameter;
  double value = 0.0;
  double sigma = 0.0;
};

// Two calibrations of one rig, a minus b, in a's IMU axes (InAxesOf). Normalised by the sigmas of both,
// sqrt(sigma_a^2 + sigma_b^2), as of different drives; calibrations of the same data differ by less.
struct CalibrationDifference {
  TruthComparison poses;
  std::vector<IntrinsicDifference> intrinsics;    // of cameras with the same model in both
  std::vector<std::string> only_in_a, only_in_b;  // names of sensors
};

CalibrationDifference Subtract(const CalibrationResult& a, const CalibrationResult& b);

// The number that differs by most sigmas.
struct LargestDifference {
  std::string of;  // such as "front_lidar, translation z"; empty where no sigma is claimed
  double sigmas = 0.0;
};
LargestDifference LargestOf(const CalibrationDifference& difference);

// For people: degrees, millimetres, milliseconds.
std::string TableOf(const CalibrationDifference& difference);

}  // namespace mlic
