#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// The rig, its sensors where an earlier calibration has them: guess with sigmas, time offset, lens. Sensors
// are known by their names. Of n sensors that are taken over, sigmas of guesses are sqrt(n) times as large:
// the file does not say how the errors hang together, and the solve takes guesses for independent, so that
// errors which all share (the height of a rig over its IMU) would average out; n times a sensor's own
// covariance is a bound of the whole's, whatever hangs together (covariance intersection). Fixed sensors are
// held where the calibration has them, with its sigmas (HeldSensors). The IMU's axes are those of the earlier
// calibration. notes: a line for each sensor that is only here or only there. InputError where the two do not
// fit, or the calibration was refused.
Rig WithPrior(const Rig& rig, const CalibrationResult& earlier, std::vector<std::string>* notes);

// The rig, all sensors but `added` fixed where an earlier calibration has them, for CalibrationOptions::
// held_from. InputError for names that the rig does not have, or where the calibration lacks one of the rest.
Rig WithAddedSensors(const Rig& rig, const CalibrationResult& earlier, const std::vector<std::string>& added,
                     std::vector<std::string>* notes);

// Whether this sensor of the rig is held where the earlier calibration has it.
template <typename Config>
bool IsHeldFrom(const CalibrationResult& earlier, const Config& config) {
  if (!config.fixed) return false;
  for (const SensorResult& sensor : earlier.sensors) {
    if (sensor.name == config.name) return true;
  }
  return false;
}

// What the rig knows of its fixed sensors that are not exact, for AddSigmasOfHeld.
CalibrationResult HeldSensors(const Rig& rig);

// Gives held sensors what the earlier calibration says of them and of their pairs, and adds to the others'
// sigmas against the IMU what these are off by with the held ones: of each component the largest that any of
// them would bring if this sensor hung at it alone, a bound of every weighted mean of them. Pairs with a held
// sensor have what the data say of the other one, and what the held sensors are off by against each other.
void AddSigmasOfHeld(const CalibrationResult& earlier, CalibrationResult* result);

}  // namespace mlic
