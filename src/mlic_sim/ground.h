#pragma once

#include <cmath>

#include "mlic_sim/taylor.h"

namespace mlic::sim {

// Height of the yard's slightly uneven ground, metres: waves of 4 to 17 m length and of 1 to 6 mm amplitude.
// Generic in the scalar, so that a car that follows it has exact accelerations.
template <typename Scalar>
Scalar UnevenGroundHeight(const Scalar& x, const Scalar& y) {
  using std::sin;
  return Scalar(0.006) * sin(Scalar(0.37) * x + Scalar(0.21) * y + Scalar(0.4)) +
         Scalar(0.005) * sin(Scalar(-0.29) * x + Scalar(0.53) * y + Scalar(1.9)) +
         Scalar(0.003) * sin(Scalar(0.83) * x - Scalar(0.47) * y + Scalar(4.1)) +
         Scalar(0.002) * sin(Scalar(0.61) * x + Scalar(1.13) * y + Scalar(2.7)) +
         Scalar(0.001) * sin(Scalar(1.49) * x - Scalar(0.31) * y + Scalar(5.5));
}

}  // namespace mlic::sim
