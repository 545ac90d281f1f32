#pragma once

#include <cstdint>

#include "mlic_sim/trajectory.h"

namespace mlic::sim {

// Constants of this file, from: definition.

struct SimulationOptions {
  Scenario scenario = Scenario::kFigureEight;
  double duration = 60.0;  // s
  std::uint64_t seed = 1;
  // False: exact IMU samples and points (biases, matrices and clock offsets stay as the sensor set says).
  bool with_noise = true;
};

}  // namespace mlic::sim
