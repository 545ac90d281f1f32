#pragma once

#include <cstdint>
#include <memory>

#include "mlic_sim/recorded_motion.h"
#include "mlic_sim/surroundings.h"
#include "mlic_sim/trajectory.h"

namespace mlic::sim {

// Constants of this file, from: definition.

struct SimulationOptions {
  Scenario scenario = Scenario::kFigureEight;
  double duration = 60.0;  // s
  std::uint64_t seed = 1;
  // False: exact IMU samples and points (biases, matrices and clock offsets stay as the sensor set says).
  bool with_noise = true;
  WorldFamily world = WorldFamily::kOfScenario;
  std::uint64_t world_seed = 1;
  std::shared_ptr<const RecordedMotion> recorded;  // in place of the scenario's motion, from zero on
  int moving_objects = 0;                          // cars, people or doors, as the world has room for
};

}  // namespace mlic::sim
