#pragma once

#include <string>

#include "mlic_core/lidar/scan_filter.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_sim/simulation.h"
#include "support/source_directory.h"

namespace mlic {

// A simulated drive in memory, as a calibration takes it.
struct SimulatedInput {
  sim::SensorSet sensors;
  Rig rig;
  Dataset dataset;
};

inline sim::SensorSet ConfiguredSensors(const std::string& file) {
  return sim::LoadSensorSet(SourceDirectory() + "/config/simulation/" + file);
}

// The same with the first LiDARs only.
inline sim::SensorSet WithFirstLidars(sim::SensorSet sensors, std::size_t count) {
  sensors.lidars.resize(count);
  return sensors;
}

// The same with half the points of spinning LiDARs, which are soon calibrated.
inline sim::SensorSet WithHalfThePoints(sim::SensorSet sensors) {
  for (sim::SimulatedLidar& lidar : sensors.lidars) lidar.model.azimuth_steps /= 2;
  return sensors;
}

// The guess, if there is one, errs by the same seed.
inline SimulatedInput SimulateInput(const sim::SensorSet& sensors, const sim::SimulationOptions& options,
                                    bool with_guess) {
  sim::GuessOptions guess;
  guess.with_guess = with_guess;
  guess.seed = options.seed;
  SimulatedInput input{sensors, sim::RigFromSensorSet(sensors, guess), {}};
  input.dataset.drives.push_back(
      sim::SimulateDrive(sensors, options, [](LidarScan& scan) { FilterScan(scan); }));
  return input;
}

inline sim::SimulationOptions DriveOptions(sim::Scenario scenario, double duration, std::uint64_t seed,
                                           bool with_noise = true) {
  sim::SimulationOptions options;
  options.scenario = scenario;
  options.duration = duration;
  options.seed = seed;
  options.with_noise = with_noise;
  return options;
}

}  // namespace mlic
