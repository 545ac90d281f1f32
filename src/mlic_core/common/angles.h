#pragma once

#include <cmath>

namespace mlic {

constexpr double kRadiansPerDegree = M_PI / 180.0;
constexpr double kDegreesPerRadian = 180.0 / M_PI;

}  // namespace mlic
