#include "mlic_core/summary/warnings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/sensors/rig.h"

namespace mlic {

void WarnOfMovement(double moved, std::vector<std::string>* warnings) {
  constexpr double kNotable = 0.5, kMost = 1.0;  // sigmas; from: definition, beyond that it is a reason
  if (moved <= kNotable || moved > kMost) return;
  char text[160];
  std::snprintf(text, sizeof(text),
                "the calibration has hardly converged: the last round moved it by %.2f of its sigma, which "
                "the sigmas here include",
                moved);
  warnings->push_back(text);
}

void WarnOfLag(double lag, double sigma, std::vector<std::string>* warnings) {
  constexpr double kLeast = 0.01;  // s; from: standard, low-pass filters of raw IMUs delay by less
  constexpr double kShown = 4.0;   // sigmas; from: derivation, 1 of 16000 normal errors lies beyond
  if (std::abs(lag) < std::max(kLeast, kShown * sigma)) return;
  char text[300];
  std::snprintf(text, sizeof(text),
                "the IMU's %s is %.0f ms later than its %s (sigma %.1f ms), as the filtered rates of "
                "navigation systems are: time offsets are to the gyroscope, and programs that take both for "
                "one time lose by it; record the raw IMU",
                lag > 0.0 ? "accelerometer" : "gyroscope", 1e3 * std::abs(lag),
                lag > 0.0 ? "gyroscope" : "accelerometer", 1e3 * sigma);
  warnings->push_back(text);
}

void WarnOfDrift(const SensorResult& sensor, std::vector<std::string>* warnings) {
  constexpr double kShown = 3.0;  // sigmas; from: derivation, 0.3 % of normal errors lie beyond
  if (std::abs(sensor.calibration.clock_drift.value_or(0.0)) <= kShown * sensor.drift_sigma) return;
  char text[280];
  if (sensor.type == SensorResult::Type::kCamera &&
      std::abs(*sensor.calibration.clock_drift) >= kFastestCrystals) {
    std::snprintf(
        text, sizeof(text),
        ": its time offset moves by %.0f us a second (sigma %.0f), faster than clocks do, as where auto "
        "exposure moves the middle of the exposure; its sigma has what it moves by; hold the exposure",
        1e6 * *sensor.calibration.clock_drift, 1e6 * sensor.drift_sigma);
    warnings->push_back(sensor.name + text);
    return;
  }
  std::snprintf(
      text, sizeof(text),
      ": its clock drifts by %.1f ppm (sigma %.1f) against the IMU's, so that its time offset holds in "
      "the middle of the drive and moves by %.1f ms an hour; synchronise the clocks",
      1e6 * *sensor.calibration.clock_drift, 1e6 * sensor.drift_sigma,
      3.6e6 * *sensor.calibration.clock_drift);
  warnings->push_back(sensor.name + text);
}

void WarnOfWander(const SensorResult& camera, double mean_square, std::vector<std::string>* warnings) {
  constexpr double kMost = 0.5;  // of the variance; from: definition
  if (mean_square <= kMost * camera.sigma.time_offset * camera.sigma.time_offset) return;
  char text[240];
  std::snprintf(
      text, sizeof(text),
      ": its stamps wander by %.2f ms (rms) about its time offset, as where auto exposure moves the "
      "middle of the exposure; they were followed, and its sigma has it; hold the exposure",
      1e3 * std::sqrt(mean_square));
  warnings->push_back(camera.name + text);
}

}  // namespace mlic
