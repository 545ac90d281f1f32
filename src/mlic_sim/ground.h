#pragma once

#include <cmath>
#include <vector>

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

// Hills under a world: a sum of waves, metres; no waves: level. What drives or walks there follows it.
// Generic in the scalar, as above.
struct Terrain {
  struct Wave {
    double amplitude;  // m
    double kx, ky;     // rad/m
    double phase;
  };
  std::vector<Wave> waves;

  template <typename Scalar>
  Scalar Height(const Scalar& x, const Scalar& y) const {
    using std::sin;
    Scalar sum(0.0);
    for (const Wave& w : waves) {
      sum += Scalar(w.amplitude) * sin(Scalar(w.kx) * x + Scalar(w.ky) * y + Scalar(w.phase));
    }
    return sum;
  }

  // Rise per metre along the direction (dx, dy).
  template <typename Scalar>
  Scalar Slope(const Scalar& x, const Scalar& y, const Scalar& dx, const Scalar& dy) const {
    using std::cos;
    Scalar sum(0.0);
    for (const Wave& w : waves) {
      sum += Scalar(w.amplitude) * cos(Scalar(w.kx) * x + Scalar(w.ky) * y + Scalar(w.phase)) *
             (Scalar(w.kx) * dx + Scalar(w.ky) * dy);
    }
    return sum;
  }
};

// What a world asks of the motions in it.
struct MotionGround {
  Terrain terrain;
  double breadth = 1.0;  // room across that a walk has, as a share of the hall's; from: definition
};

}  // namespace mlic::sim
