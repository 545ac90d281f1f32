#pragma once

#include <string>

#include "mlic_core/common/error.h"
#include "mlic_core/sensors/sensor_id.h"

namespace mlic {

// Why a sensor of the rig takes no part: one line for people, which names it.
struct SensorProblem {
  std::string sensor;
  std::string reason;
};

// What one sensor recorded cannot be used; the others may be calibrated without it.
class UnusableSensor : public InputError {
 public:
  UnusableSensor(SensorId sensor, const std::string& message) : InputError(message), sensor_(sensor) {}
  SensorId Sensor() const { return sensor_; }

 private:
  SensorId sensor_;
};

// Runs work on what one sensor recorded. Throws UnusableSensor where it throws InputError.
template <typename Work>
auto OfSensor(SensorId sensor, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw UnusableSensor(sensor, error.what());
  }
}

}  // namespace mlic
