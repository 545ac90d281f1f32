#pragma once

#include <utility>

#include "mlic_core/problem/linear_terms.h"

namespace mlic {

// Part `chunk` (of kLinearizationChunks) of one drive's IMU samples: from and to.
std::pair<std::size_t, std::size_t> ImuPart(const LinearizationPoint& at, std::size_t drive,
                                            std::size_t chunk);

// Adds part `chunk` of one drive's IMU samples.
void AddImu(const LinearizationPoint& at, std::size_t drive, std::size_t chunk, Accumulator* sum);

// What AddImu adds to the cost.
double ImuCost(const LinearizationPoint& at, std::size_t drive, std::size_t chunk);

// Adds the poses that one drive's trajectory is drawn to.
void AddPoses(const LinearizationPoint& at, std::size_t drive, Accumulator* sum);

// What AddPoses adds to the cost.
double PoseCost(const LinearizationPoint& at, std::size_t drive);

// Fixes the map's position and yaw where they are, at the start of the drive (factors/gauge.h).
void AddGauge(const LinearizationPoint& at, std::size_t drive, Accumulator* sum);

// IMU residuals of one drive, six for each sample within the trajectory (rad/s, m/s^2), with the samples'
// times.
struct ImuResiduals {
  std::vector<double> times;
  std::vector<Eigen::Matrix<double, 6, 1>> values;
};
ImuResiduals EvaluateImuResiduals(const Dataset& dataset, const CalibrationState& state, std::size_t drive);

}  // namespace mlic
