#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// Errors of one estimated pose, estimate minus truth. Vectors are in the first frame (IMU, or a of a pair
// a/b): translation in metres, rotation as the small left rotation Log(R_estimate R_truth^-1) in radians,
// whose length is the geodesic angle. Normalised: divided by the claimed sigma, component by component; NaN
// where none is claimed.
struct PoseError {
  std::string name;  // of the sensor, or "a/b"
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
  std::optional<double> time_offset;  // s; of a pair: of the difference offset_b - offset_a
  Eigen::Vector3d normalised_translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d normalised_rotation = Eigen::Vector3d::Zero();
  double normalised_time_offset = 0.0;
  std::array<bool, 3> translation_observable{true, true, true};

  double RotationDegrees() const;
};

struct TruthComparison {
  std::vector<PoseError> sensors;
  std::vector<PoseError> pairs;
  std::vector<std::string> not_estimated;  // in the truth, not in the result
};

// The result's sensor of this name; null where it has none.
const SensorResult* FindSensor(const CalibrationResult& result, const std::string& name);

// The result's own pairs, or all pairs of its sensors (without sigmas) when it lists none.
std::vector<PairResult> PairsOf(const CalibrationResult& result);

// The truth in the axes that the result's IMU has: the gyroscope's, and about ImuAlignment::of_accelerometer
// those of the accelerometer. The true rotation between the two is the truth's accelerometer_matrix. Poses
// turn with the axes; pairs, offsets and what is not a pose stay. As given where the result's axes are not
// known.
CalibrationResult InAxesOf(const CalibrationResult& result, const CalibrationResult& truth);

// Against the truth in the result's axes (InAxesOf). Sensors are matched by name; those the truth does not
// know are left out. Pairs: PairsOf.
TruthComparison CompareWithTruth(const CalibrationResult& result, const CalibrationResult& truth);

// For people: degrees, millimetres, milliseconds; a * marks a translation that was not observable. title:
// what the numbers are.
std::string TableOf(const TruthComparison& comparison, const char* title = "error against truth");

// One line for each sensor and pair, header first; metres, degrees, seconds.
std::string CsvOf(const TruthComparison& comparison);

}  // namespace mlic
