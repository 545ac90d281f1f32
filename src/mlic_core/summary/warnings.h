#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// Warnings of the result that no check gives. Each adds a line, or none where nothing is to be said.

// moved: by the last round of all that were allowed, in sigmas; 0 where the calibration stood still before.
void WarnOfMovement(double moved, std::vector<std::string>* warnings);

// An accelerometer and a gyroscope of one IMU that do not keep one time. lag, sigma: of the accelerometer
// behind the gyroscope, s.
void WarnOfLag(double lag, double sigma, std::vector<std::string>* warnings);

// A clock that drifts: the sensor's time offset is right for this drive alone.
void WarnOfDrift(const SensorResult& sensor, std::vector<std::string>* warnings);

// Stamps of a camera that wander about its time offset by most of its sigma. mean_square: of what they wander
// by, s^2, part of the sigma.
void WarnOfWander(const SensorResult& camera, double mean_square, std::vector<std::string>* warnings);

}  // namespace mlic
