#pragma once

namespace mlic {

// What a clock gains on the IMU's beyond a constant: drift * (t - middle). drift: s/s; middle: s since the
// drive's epoch.
struct ClockDrift {
  double drift = 0.0;
  double middle = 0.0;

  double Without(double time) const { return time + drift * (time - middle); }
};

}  // namespace mlic
