#pragma once

#include <string>

namespace mlic {

// Why a sensor of the rig takes no part: one line for people, which names it.
struct SensorProblem {
  std::string sensor;
  std::string reason;
};

}  // namespace mlic
