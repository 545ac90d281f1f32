#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "mlic_core/imu/excitation.h"

namespace mlic {

// Sigmas of an IMU's samples over a drive. Stretches that shake more than it usually does (a bump, a knock, a
// rig that is set down) have larger ones: they say less, and nothing of the time before and after.
struct ImuSigmaCourse {
  ImuSigma usual;
  double start = 0.0, length = 1.0;             // of the stretches, s on the IMU's clock
  std::vector<std::array<double, 2>> growth{};  // of each, at least 1: gyroscope, accelerometer; empty: none

  // The last stretch is longer, by what is left.
  ImuSigma At(double time) const {
    if (growth.empty()) return usual;
    const double last = static_cast<double>(growth.size()) - 1.0;
    const auto& [gyroscope, accelerometer] =
        growth[static_cast<std::size_t>(std::clamp((time - start) / length, 0.0, last))];
    return {gyroscope * usual.gyroscope, accelerometer * usual.accelerometer};
  }
};

}  // namespace mlic
